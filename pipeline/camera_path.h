#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/rig.h"
#include "core/view.h"

namespace floatstage::pipeline {

/// One key frame of a camera path: where the virtual camera stands and looks at a time of the film.
struct PathKey {
  double time = 0;  ///< seconds from the film's start
  Eigen::Vector3d eye = Eigen::Vector3d::Zero(), target = Eigen::Vector3d::Zero(),
                  up = Eigen::Vector3d::UnitZ();
  double fov_y = 40;  ///< vertical field of view, degrees
};

/// A camera path: keys in order of time, joined by a Catmull-Rom spline (centripetal in time), held before
/// and after.
struct CameraPath {
  std::vector<PathKey> keys;
  double duration() const { return keys.empty() ? 0 : keys.back().time; }
};

PathKey sample(const CameraPath& path, double time);

/// The view of a key: square pixels, principal point in the middle, near and far around `subject`.
View view_of(const PathKey& key, int width, int height, const Eigen::AlignedBox3d& subject);

/// path.json: {"floatstage_path": 1, "keys": [{"time", "eye", "target", "up", "fov_y"}]}.
Result<CameraPath> parse_path(std::string_view json, std::string_view name_for_errors);
std::string to_json(const CameraPath& path);
Result<CameraPath> load_path(const std::filesystem::path& file);
Result<void> save_path(const CameraPath& path, const std::filesystem::path& file);

}  // namespace floatstage::pipeline
