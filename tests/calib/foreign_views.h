#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/rig_formats.h"
#include "core/rig.h"

namespace floatstage::calib {

/// Where other programs see points through an exported rig, against our own projection by the rig itself.

/// Points all over a camera's picture, `distance` before it and a little further.
std::vector<Eigen::Vector3d> points_before(const RigCamera& camera, double distance = 1.5);

/// How far from our pixel OpenCV's projectPoints (of a fisheye, fisheye::projectPoints) sees any point of any
/// camera's picture, px. `exported`: what stands in the export's files; `world`: what ours is in the world
/// they have.
double furthest_by_opencv(const Rig& rig, const Rig& exported, const Rigid3& world = {});

/// The numbers of intri.yml and extri.yml as cv::FileStorage reads them; nothing is left to our reader.
Rig read_by_opencv(const std::filesystem::path& folder, const Rig& names_and_sizes);

/// The RMS that COLMAP's bundle_adjuster finds at first when points are where our projection sees them, px;
/// absent where COLMAP is not installed. `model` was written by write_colmap; `out` is a folder.
std::optional<double> first_cost_of_colmap(const Rig& rig, const std::filesystem::path& model,
                                           const std::filesystem::path& out);

}  // namespace floatstage::calib
