#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "capture/camera_control.h"
#include "core/result.h"

namespace floatstage::studio {

/// How one camera of a node does. What the device or the link does not tell is absent.
struct NodeCamera {
  std::string serial;
  std::uint64_t delivered = 0, lost = 0, corrupt = 0, failed = 0, reconnects = 0;
  double frame_rate = 0;  ///< measured
  std::optional<double> temperature_c;
  std::optional<double> bandwidth_mbit;  ///< on its link
  std::string trouble;                   ///< the last error; empty while it streams
  std::uint64_t starved = 0;             ///< pictures that its device had no buffer for
  int width = 0, height = 0;             ///< px
};

/// A sound track of a take that is being recorded.
struct NodeSound {
  std::string name;
  double seconds = 0;
  double peak = 0;     ///< 0 … 1 of full scale, about now
  bool ended = false;  ///< its device is gone
};

/// A take that is being recorded.
struct NodeRecording {
  std::string take;  ///< name of its folder
  double seconds = 0;
  std::uint64_t frames = 0;  ///< rows with a picture, over all cameras
  std::uint64_t gaps = 0;    ///< rows without one
  std::uint64_t duplicates = 0;
  std::vector<std::string> complaints;  ///< of its verdict so far
  std::vector<NodeSound> sounds = {};
};

/// How a camera node does.
struct NodeStatus {
  std::string node;  ///< its name in the studio
  std::vector<NodeCamera> cameras;
  double spread_p50_ms = 0, spread_max_ms = 0;  ///< between the exposures of one instant
  std::uint64_t disk_free_bytes = 0;            ///< where takes are written
  std::optional<NodeRecording> recording;
  double frame_rate = 0;                ///< nominal
  std::vector<std::string> complaints;  ///< why a take should not begin now: what the synchroniser sees
  std::string last_recording;           ///< why the last take ended, where nobody asked it to; else empty
  std::optional<double> disk_minutes;   ///< of recording; absent while nothing streams
  double preroll_seconds = 0;
};

/// A take on a node's disk.
struct NodeTake {
  std::string name;     ///< of its folder
  std::string created;  ///< UTC, ISO 8601
  std::uint64_t bytes = 0;
  bool complete = false;
  std::string verdict;  ///< "PASS", "FAIL", or empty where there is none
  double seconds = 0;
  int cameras = 0;
};

/// What one camera of a node lets be set while it streams.
struct NodeControls {
  std::string serial;
  std::vector<capture::CameraControl> controls;
};

/// What one may ask of a running camera node: the same for the network (studio/network/control_server.h),
/// for the page that the node serves and for a viewer in the same process. All functions may be called from
/// any thread, also at once; none waits for a camera but set_control() and apply_preset().
class StudioControl {
 public:
  virtual ~StudioControl() = default;
  virtual NodeStatus status() const = 0;
  /// Begins a take, preroll_seconds earlier than now, and returns the name of its folder. An empty label: the
  /// one of the configuration. Errors: AlreadyExists while one is being recorded, InvalidArgument for a label
  /// that cannot be a file name and, where the configuration refuses such takes, while the cameras disagree;
  /// Io.
  virtual Result<std::string> start_recording(const std::string& label) = 0;
  /// Ends the take, at an instant that all cameras saw: all of it is on disk when this returns. NotFound when
  /// none is recorded.
  virtual Result<void> stop_recording() = 0;
  /// Newest first.
  virtual Result<std::vector<NodeTake>> takes() const = 0;

  /// Exposure, gain and white balance of all cameras, as they were read last: what is asked again half a
  /// second later is new. Empty where this cannot be asked (from another machine).
  virtual std::vector<NodeControls> controls() const { return {}; }
  /// Turns one; waits for the camera, 3 s at most. NotFound for a camera or control that there is not,
  /// InvalidArgument, with the range, for a value that the camera refuses, Timeout, Unsupported where this
  /// cannot be asked.
  virtual Result<void> set_control(const std::string& /*serial*/, const std::string& /*name*/,
                                   double /*value*/) {
    return fail(ErrorCode::Unsupported, "controls are set on the machine that has the camera");
  }
  /// Names of kept settings of all cameras, sorted.
  virtual Result<std::vector<std::string>> presets() const { return std::vector<std::string>(); }
  /// Keeps what controls() says under a name, in place of one that has it. InvalidArgument for a name that is
  /// not 1 to 60 letters, digits, '.', '-' and '_'; Unsupported where there is no file for presets.
  virtual Result<void> save_preset(const std::string& /*name*/) {
    return fail(ErrorCode::Unsupported, "presets are kept on the machine that has the cameras");
  }
  /// Sets them again. NotFound; else the first error of set_control(), after all others were tried; of a
  /// camera that does not answer, one.
  virtual Result<void> apply_preset(const std::string& /*name*/) {
    return fail(ErrorCode::Unsupported, "presets are kept on the machine that has the cameras");
  }
};

}  // namespace floatstage::studio
