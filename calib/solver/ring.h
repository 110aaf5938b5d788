#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

namespace floatstage::calib::solver {

/// A circle in space.
struct Ring {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of unit length
  double radius = 0;

  /// How far a point is from it: along the axis, and from it.
  Eigen::Vector2d off(const Eigen::Vector3d& point) const;
};

/// The circle of least squares across its plane, in the plane of least squares. Absent for fewer than four
/// points, and for such as lie in one place or in line.
std::optional<Ring> fit_ring(std::span<const Eigen::Vector3d> points);

}  // namespace floatstage::calib::solver
