#pragma once

#include <memory>
#include <string>

#include "capture/frame_source.h"

namespace floatstage::capture {

inline constexpr const char* kV4l2Usage =
    "v4l2:<device>?format=rgb8|yuyv|nv12|bayer-rggb8|mjpeg|gray8&width=0&height=0&rate=&controls=<name>:<"
    "value>,…&"
    "buffers=8&frames=0";

/// A camera of the Linux kernel's Video4Linux2, by raw ioctls. Opening parses only; start() opens the device.
///
/// Pictures are lent without a copy: a frame's pixels are the driver's mapped buffer, which is queued again
/// when the last copy of the frame is dropped, on any thread. Motion JPEG is decoded to Rgb8 here. A buffer
/// that the driver flags as an error is delivered as Corrupt; a jump of its sequence is lost frames. frames=N
/// ends the stream after the N-th expected picture.
///
/// Time: a monotonic stamp at the start of the exposure is taken as it is; one at the end of the readout is
/// moved back by one frame period, which is the longest that exposure and readout take. A stamp of another
/// clock, or one that lies not within seconds of now (drivers' counters wrap), is a device time that a
/// ClockMap maps.
///
/// Errors name the device: NotFound, Unsupported, InvalidArgument as of apply_settings(), Io when streaming
/// does not start (with the cause that the error number stands for), Disconnected when the device or its
/// stream is gone.
Result<std::unique_ptr<FrameSource>> open_v4l2(const std::string& address, const std::string& uri);

}  // namespace floatstage::capture
