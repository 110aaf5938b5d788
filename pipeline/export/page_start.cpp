#include "pipeline/export/page_start.h"

#include <cmath>
#include <numbers>

#include "pipeline/ring.h"

namespace floatstage::pipeline {
namespace {

constexpr double kFieldOfView = 40;  // degrees, where nothing is said

}  // namespace

PageStart page_start(const Rig& rig, const Eigen::AlignedBox3d& subject) {
  PageStart start;
  start.target = subject.center();
  start.up = up_axis(rig).direction;
  const auto level = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(v - start.up * v.dot(start.up));
  };
  const Eigen::Vector3d first = level(rig.cameras.front().cam_from_world.center() - start.target);
  start.east = first.norm() > 1e-9 ? Eigen::Vector3d(first.normalized()) : start.up.unitOrthogonal();
  for (const RigCamera& camera : rig.cameras) {
    const Eigen::Vector3d d = camera.cam_from_world.center() - start.target;
    start.elevation += std::atan2(d.dot(start.up), level(d).norm()) / static_cast<double>(rig.cameras.size());
  }
  start.distance = 0.5 * subject.diagonal().norm() / std::sin(0.5 * kFieldOfView * std::numbers::pi / 180);
  start.fov_y = kFieldOfView;
  return start;
}

}  // namespace floatstage::pipeline
