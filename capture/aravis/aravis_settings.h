#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/aravis/gobject.h"
#include "capture/camera_control.h"
#include "core/frame.h"
#include "core/result.h"

namespace floatstage::capture {

/// When a camera exposes.
enum class GigeTrigger {
  FreeRun,   ///< by its own clock
  Software,  ///< when told over the network
  Line,      ///< by an edge on a line
};

/// What is asked of a GigE Vision (or USB3 Vision) camera. What is absent stays as the camera has it.
struct AravisSettings {
  std::string serial;
  std::string address;  ///< IP address; empty: found by the serial
  std::optional<PixelFormat> format;
  int x = 0, y = 0, width = 0, height = 0;  ///< region, px; width 0: as it is
  std::optional<double> frame_rate;         ///< pictures a second
  std::optional<double> exposure_us;
  std::optional<double> gain;
  GigeTrigger trigger = GigeTrigger::FreeRun;
  std::string line = "Line1";  ///< for GigeTrigger::Line
  bool ptp = false;            ///< follow the network's clock (PtpEnable, GevIEEE1588)
  double ptp_wait_s = 10;      ///< how long a camera may take to find that clock
  int packet_bytes = 0;        ///< 0: the largest that passes
  int cameras_on_link = 1;     ///< equal cameras that share the link
  double link_mbit = 1000;
  bool resend = true;         ///< ask for lost packets again
  bool packet_socket = true;  ///< receive below the IP stack where the system allows it
  int buffers = 16;
};

/// What the camera answered.
struct AravisStream {
  ImageLayout layout;
  double frame_rate = 0;  ///< 0 when the camera does not say
  std::optional<Nanoseconds> exposure;
  std::size_t payload_bytes = 0;
  bool ptp_locked = false;
  std::vector<std::string> warnings;
};

/// Writes the settings into the camera and reads back what holds. Errors name the serial: Unsupported for a
/// feature that the camera has not and was asked for, InvalidArgument for values it refuses and links that
/// are too narrow, Timeout for a clock that does not lock to PTP, Cancelled once `stop` says yes meanwhile.
Result<AravisStream> apply_settings(ArvCamera* camera, const AravisSettings& settings,
                                    const std::function<bool()>& stop = {});

inline constexpr const char* kExposureControl = "exposure-us";

/// Exposure, gain and the white balance's ratios, as far as the camera has them.
std::vector<CameraControl> light_controls(ArvCamera* camera);
/// One of them; what sets it by itself is switched off. Errors: those of check_control(). `serial` names the
/// camera.
Result<void> set_light_control(ArvCamera* camera, const std::string& serial, const std::string& name,
                               double value);

}  // namespace floatstage::capture
