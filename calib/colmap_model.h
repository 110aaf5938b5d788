#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/rig.h"

namespace floatstage::calib {

/// A point of a surface in a sparse model.
struct ColmapPoint {
  Eigen::Vector3d position;  ///< metres
  std::array<std::uint8_t, 3> color{};
};

/// Writes a model of COLMAP 3.8 into a folder, which is made: cameras, images and points3D, each as .txt and
/// as .bin, with one camera and one image (named by `image_names`) for each camera of the rig. Points have no
/// tracks: point_triangulator aborts on a model whose images have other keypoints than its database. Errors:
/// Unsupported for skewed pixels, which COLMAP has not; InvalidArgument; Io. Some files may be there then.
Result<void> write_colmap_model(const Rig& rig, const std::vector<std::string>& image_names,
                                std::span<const ColmapPoint> points, const std::filesystem::path& folder);

}  // namespace floatstage::calib
