#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/rig.h"
#include "core/view.h"

namespace floatstage::pipeline {

/// Where the subject's centre is in each frame of a take, smoothed. Metres, world.
struct SubjectTrack {
  std::vector<Eigen::Vector3d> centres;  ///< one a frame
  double frame_rate = 0;                 ///< of the take; 0: one instant

  /// In the frame that is shown at a second of the take, the first or last outside of it; the origin without
  /// frames.
  Eigen::Vector3d at(double take_time) const;
};

/// One key frame of a camera path: where the virtual camera stands and looks at a time of the film.
struct PathKey {
  double time = 0;  ///< seconds from the film's start
  Eigen::Vector3d eye = Eigen::Vector3d::Zero(), target = Eigen::Vector3d::Zero(),
                  up = Eigen::Vector3d::UnitZ();
  double fov_y = 40;  ///< vertical field of view, degrees
  /// Seconds from the take's start, at its recorded rate, that the film shows then. Absent: as its neighbours
  /// say.
  std::optional<double> take_time = {};
  /// What the camera slows down by before and after the key: 0 not at all, 1 to a standstill.
  double ease_in = 0, ease_out = 0;
  bool follow = false;  ///< eye and target are seen from the subject's centre, and go along with it
  /// To the next key around the target, by so many whole turns more than the shortest way; positive is
  /// counter-clockwise seen from above. Absent: as the spline goes.
  std::optional<int> orbit = {};

  friend bool operator==(const PathKey&, const PathKey&) = default;
};

/// A camera path: keys in order of time, joined by a Catmull-Rom spline (centripetal in time), held before
/// and after (docs/adr/0284-camera-paths-in-two-times.md).
struct CameraPath {
  std::vector<PathKey> keys;

  double duration() const { return keys.empty() ? 0 : keys.back().time; }
  bool follows() const;         ///< some key does
  bool has_take_times() const;  ///< some key says one

  friend bool operator==(const CameraPath&, const CameraPath&) = default;
};

/// The camera at a second of the film, in the world. `subject` is where keys that follow are seen from.
PathKey sample(const CameraPath& path, double time, const SubjectTrack& subject = {});

/// The second of the take that is shown at a second of the film: straight lines between the keys that say it,
/// at the recorded rate before and after them; the film's own second when none does.
double take_time(const CameraPath& path, double time);

/// Which of `frames` of a take of this rate is shown at a second of the film: the one nearest to take_time();
/// where no key says one they are played in order, and begun again. There is one frame at least.
std::size_t shown_at(const CameraPath& path, double time, double take_rate, std::span<const int> frames);

/// The view of a key: square pixels, principal point in the middle, near and far around `subject`.
View view_of(const PathKey& key, int width, int height, const Eigen::AlignedBox3d& subject);

/// path.json: {"floatstage_path": 2, "keys": [{"time", "eye", "target", "up", "fov_y"}]}, and of a key
/// "take_time", "ease_in", "ease_out", "follow", "orbit" where they are not as PathKey has them. Version 1
/// had none of these. BadData, Unsupported for another version.
Result<CameraPath> parse_path(std::string_view json, std::string_view name_for_errors);
std::string to_json(const CameraPath& path);
Result<CameraPath> load_path(const std::filesystem::path& file);
/// For cameras that have no take: InvalidArgument for a path that follows a take's subject.
Result<CameraPath> load_path_without_take(const std::filesystem::path& file);
Result<void> save_path(const CameraPath& path, const std::filesystem::path& file);

}  // namespace floatstage::pipeline
