#pragma once

#include <memory>
#include <string>

#include "capture/frame_source.h"

namespace floatstage::capture {

inline constexpr const char* kAravisUsage =
    "gige:<serial>?address=&format=gray8|rgb8|bayer-rggb8|yuyv&x=0&y=0&width=0&height=0&rate=&exposure-us=&"
    "gain=&"
    "trigger=free-run|software|<line>&ptp=off|on&ptp-wait=10&packet=0&cameras=1&link-mbit=1000&resend=on|off&"
    "packet-socket=auto|on|off&buffers=16&frames=0";

/// A camera that speaks GigE Vision or USB3 Vision, through Aravis. Opening parses only; start() finds the
/// camera, writes the settings and streams.
///
/// Pictures are lent without a copy: a frame's pixels are the receive buffer, which goes back to the stream
/// when the last copy of the frame is dropped, on any thread. When all `buffers` are held, frames are lost
/// and counted as starved. frames=N ends the stream after the N-th expected picture. With trigger=software
/// every call of next() asks for one picture. A buffer that did not arrive whole is lost, never delivered:
/// each is one lost frame, as is each jump of the device's frame number. Exposure times are device times
/// mapped by a ClockMap from the arrival of the first packet, or as they are where PTP is locked.
///
/// Errors name the camera: NotFound when nobody answers to the serial, Disconnected when the control channel
/// is lost, and what apply_settings() refuses.
Result<std::unique_ptr<FrameSource>> open_aravis(const std::string& address, const std::string& uri);

}  // namespace floatstage::capture
