#include "apps/viewer/play/viewer_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace floatstage::apps {
namespace {

using Eigen::Vector3d;
constexpr double kPole = 0.02;     // radians that the view stays away from straight up and down
constexpr double kNearest = 0.05;  // metres
constexpr double kPi = std::numbers::pi;

}  // namespace

ViewerCamera::ViewerCamera(const pipeline::PathKey& start) { set(start); }

void ViewerCamera::set(const pipeline::PathKey& key) {
  key_.eye = key.eye;
  key_.target = key.target;
  key_.up = key.up.normalized();
  key_.fov_y = key.fov_y;
}

ViewerCamera::Axes ViewerCamera::axes() const {
  const Vector3d forward = (key_.target - key_.eye).normalized(), right = forward.cross(key_.up).normalized();
  return {right, right.cross(forward), forward};
}

Vector3d ViewerCamera::turned(const Vector3d& direction, double right, double up) const {
  const double length = direction.norm(),
               elevation = std::asin(std::clamp(direction.dot(key_.up) / length, -1.0, 1.0));
  const double wanted = std::clamp(elevation + up, -kPi / 2 + kPole, kPi / 2 - kPole);
  const Vector3d level = (direction - key_.up * direction.dot(key_.up)).normalized();
  const Vector3d heading = Eigen::AngleAxisd(right, key_.up) * level;
  return length * (std::cos(wanted) * heading + std::sin(wanted) * key_.up);
}

void ViewerCamera::orbit(double right, double up) {
  key_.eye = key_.target + turned(key_.eye - key_.target, right, up);
}

void ViewerCamera::look(double right, double up) {
  key_.target = key_.eye + turned(key_.target - key_.eye, -right, up);
}

void ViewerCamera::pan(double right, double up) {
  const Axes a = axes();
  const double height = 2 * (key_.target - key_.eye).norm() * std::tan(key_.fov_y * kPi / 360);
  const Vector3d move = (a.right * right + a.up * up) * height;
  key_.eye += move;
  key_.target += move;
}

void ViewerCamera::zoom(double factor) {
  const Vector3d back = key_.eye - key_.target;
  key_.eye = key_.target + back.normalized() * std::max(back.norm() / factor, kNearest);
}

void ViewerCamera::fly(double right, double up, double forward) {
  const Axes a = axes();
  const Vector3d move = a.right * right + a.up * up + a.forward * forward;
  key_.eye += move;
  key_.target += move;
}

}  // namespace floatstage::apps
