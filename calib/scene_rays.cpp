#include "calib/scene_rays.h"

#include <Eigen/Dense>

namespace floatstage::calib {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::optional<Vector3d> meeting_point(const Rig& rig, std::span<const std::pair<int, Eigen::Vector2d>> seen) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const auto& [camera, pixel] : seen) {
    const RigCamera& c = rig.cameras[static_cast<std::size_t>(camera)];
    const std::optional<Vector3d> ray = unproject(c.model, pixel);
    if (!ray) continue;
    const Vector3d d = (c.cam_from_world.rotation.conjugate() * *ray).normalized();
    const Matrix3d across = Matrix3d::Identity() - d * d.transpose();
    normal += across;
    right += across * c.cam_from_world.center();
  }
  constexpr double kLeastParallax = 3e-3;  // about 5° between two rays
  if (!(Eigen::SelfAdjointEigenSolver<Matrix3d>(normal).eigenvalues()[0] > kLeastParallax))
    return std::nullopt;
  return Vector3d(normal.ldlt().solve(right));
}

}  // namespace floatstage::calib
