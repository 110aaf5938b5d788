#pragma once

#include <optional>
#include <span>
#include <utility>

#include <Eigen/Core>

#include "core/rig.h"

namespace floatstage::calib {

/// Where the rays of one point meet (least squares); absent when they are nearly parallel. Private to calib.
std::optional<Eigen::Vector3d> meeting_point(const Rig& rig,
                                             std::span<const std::pair<int, Eigen::Vector2d>> seen);

}  // namespace floatstage::calib
