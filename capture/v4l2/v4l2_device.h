#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <linux/videodev2.h>

#include "capture/camera_control.h"
#include "core/frame.h"
#include "core/result.h"

namespace floatstage::capture {

/// An open video device. Closes itself. ioctl() may be called from any thread.
class V4l2Device {
 public:
  /// NotFound, Io (no permission, busy) or Unsupported (no camera), each with what to do. Names the path.
  static Result<V4l2Device> open(const std::string& path);
  V4l2Device(V4l2Device&& other) noexcept;
  ~V4l2Device();

  int fd() const { return fd_; }
  /// 0, or the errno; asks again when interrupted by a signal.
  int ioctl(unsigned long request, void* argument) const;

 private:
  explicit V4l2Device(int fd) : fd_(fd) {}
  int fd_ = -1;
};

/// What is asked of a V4L2 camera; what is absent stays as the driver has it.
struct V4l2Settings {
  std::string path;  ///< "/dev/video0"
  std::optional<PixelFormat> format;
  int width = 0, height = 0;  ///< px; 0: as it is
  std::optional<double> frame_rate;
  std::vector<std::pair<std::string, int>>
      controls;  ///< by name, as "brightness" or "exposure-time-absolute"
  int buffers = 8;
};

/// What the driver answered.
struct V4l2Format {
  ImageLayout device;     ///< of the driver's buffers; for Mjpeg size_bytes is the largest picture
  double frame_rate = 0;  ///< 0 when the driver does not say
  std::optional<Nanoseconds> exposure;
};

/// Negotiates format, size, rate and controls. Errors name the device and list what it offers: Unsupported
/// for a format, size or control it has not, InvalidArgument for a value out of a control's range.
Result<V4l2Format> apply_settings(const V4l2Device& device, const V4l2Settings& settings);

/// As the device says it; absent where it does not.
std::optional<Nanoseconds> exposure_time(const V4l2Device& device);
/// Exposure, gain, white balance, focus and brightness, as far as the device has them and lets them be set
/// now.
std::vector<CameraControl> light_controls(const V4l2Device& device);
/// One of them, rounded to a whole number. Errors: those of check_control(). `path` names the device.
Result<void> set_light_control(const V4l2Device& device, const std::string& path, const std::string& name,
                               double value);

/// Why a device does not stream, in words for its user: what an errno means there and what to do.
const char* why_not_streaming(int error);

/// A control's name in words of a command line: "Exposure Time, Absolute" becomes "exposure-time-absolute".
std::string control_word(std::string_view name);

}  // namespace floatstage::capture
