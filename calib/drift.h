#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::calib {

/// A piece of a camera's background as it looked when the studio was calibrated.
struct DriftPatch {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  ///< px, corner origin: its centre
  std::vector<std::uint8_t> grey;                ///< kDriftPatch² pixels, by rows
  bool operator==(const DriftPatch&) const = default;
};
inline constexpr int kDriftPatch = 15;  ///< px a side

/// What the watch compares with: per camera of the rig, patches spread over the picture.
struct DriftReference {
  std::vector<std::string> serials;
  std::vector<std::vector<DriftPatch>> patches;
  bool operator==(const DriftReference&) const = default;
};

/// Picks up to `most` well-textured patches a camera, at most one in each cell of a grid. images[i] (1 or 3
/// channels, the rig's size) belongs to rig.cameras[i]; an empty image gives no patches. InvalidArgument when
/// sizes do not match.
Result<DriftReference> make_drift_reference(const Rig& rig, const std::vector<Image>& images, int most = 60);

/// Kept beside the rig: JSON {"floatstage_drift_reference": 1, "cameras": [{"serial", "patches": [{"at",
/// "grey"}]}]}, grey as hexadecimal.
std::string to_json(const DriftReference& reference);
Result<DriftReference> parse_drift_reference(std::string_view json, std::string_view name_for_errors);
Result<DriftReference> load_drift_reference(const std::filesystem::path& file);
Result<void> save_drift_reference(const DriftReference& reference, const std::filesystem::path& file);

/// How one camera has turned since, from one picture. The homography of a turn is K R K⁻¹: R is fitted to the
/// rays of the patches that are found again, by consensus, so that people before the background do not
/// matter.
struct CameraTurn {
  bool known = false;  ///< enough of the background is visible and agrees
  double degrees = 0;  ///< angle of the turn
  Eigen::Vector3d axis_degrees =
      Eigen::Vector3d::Zero();  ///< rotation vector in the camera's frame: pitch (x), yaw (y), roll (z)
  double sigma_degrees = 0;
  double moved_px = 0;     ///< median shift of the background
  double residual_px = 0;  ///< RMS that the turn leaves: large where the camera has moved, not only turned
  int matches = 0, patches = 0;
  /// What no turn explains: a camera that has moved sees near things shift before far ones, all along the
  /// epipolar lines of one direction. The upper quartile of those shifts, and the median of what is left
  /// across the lines. (Which direction that is, a few pixels do not tell: along the view and across it look
  /// alike.)
  double parallax_px = 0, epipolar_px = 0;
};
CameraTurn measure_turn(const CameraModel& model, const std::vector<DriftPatch>& reference,
                        const Image& image);

struct DriftOptions {
  double alarm_degrees = 0.1;
  double alarm_parallax_px = 0.8;
  int consecutive = 2;  ///< checks in a row that must say so
};

struct DriftAlarm {
  std::string serial;
  double time = 0;  ///< seconds, of the check that raised it
  double degrees = 0;
  double residual_px = 0;
  bool moved = false;  ///< not only turned: parallax_px says so
  double parallax_px = 0;
  std::string sentence;  ///< names the camera, the angle and what to do
};

/// Watches a running or a recorded take. Not thread safe.
class DriftWatch {
 public:
  /// InvalidArgument when the rig and the reference name different cameras.
  static Result<DriftWatch> create(const Rig& rig, DriftReference reference,
                                   const DriftOptions& options = {});
  /// One camera's picture at a time (seconds). An alarm is given once, when it is raised; the camera's next
  /// only after it came back.
  std::optional<DriftAlarm> check(int camera, double time, const Image& image);
  /// Of the latest check of each camera.
  const std::vector<CameraTurn>& turns() const { return turns_; }

 private:
  DriftWatch(const Rig& rig, DriftReference reference, const DriftOptions& options);
  Rig rig_;
  DriftReference reference_;
  DriftOptions options_;
  std::vector<CameraTurn> turns_;
  std::vector<int> in_a_row_;
  std::vector<bool> alarmed_;
};

}  // namespace floatstage::calib
