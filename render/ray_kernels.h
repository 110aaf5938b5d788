#pragma once

#include <cstddef>

#include <Eigen/Core>

// Loops over rays from one point to many cameras, compiled for whatever instruction sets the processor may
// have. Private to the stage.
namespace floatstage::render {

/// Lists of rays are padded to it.
inline constexpr std::size_t kRayLanes = 8;

/// The rays of unit length from `point` to `count` places, a multiple of kRayLanes: x, then y, then z of all.
/// Where a place is the point itself the ray is zero.
void unit_rays(const Eigen::Vector3d& point, const double* places, std::size_t count, double* rays);

/// Adds `weight` times half the angle between each of `count` rays and `ray`, all of unit length, to `sums`.
void add_angles(const Eigen::Vector3d& ray, double weight, const double* rays, std::size_t count,
                double* sums);

}  // namespace floatstage::render
