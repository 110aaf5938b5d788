#pragma once

#include <cstdint>

#include "core/rig.h"

namespace floatstage::synthetic {

/// Points all over the volume that the performer dances in (world, metres): where a calibration error is
/// felt.
std::vector<Eigen::Vector3d> performer_volume();

/// The rig as a faulty calibration would publish it. Each camera's pose, focal length and principal point are
/// moved in a random direction, as far as makes the root mean square of the projection error of
/// performer_volume(), per image axis, `error` px (within 1 %). Exactly the true rig when `error` is 0.
Rig with_calibration_error(const Rig& rig, double error, std::uint64_t seed);

}  // namespace floatstage::synthetic
