#include "core/synthetic/calibration_error.h"

#include <cmath>
#include <optional>

#include "core/random.h"
#include "core/synthetic/sensor.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// What a calibration gets wrong, in proportions that share the error about equally between pose and lens.
struct Mistake {
  Vector3d turn, shift;      // radians, metres
  double zoom;               // relative
  Vector2d principal_point;  // px
};

Mistake draw(Random& random) {
  auto normal3 = [&](double scale) {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return Vector3d(scale * x, scale * y, scale * z);
  };
  Mistake m;
  m.turn = normal3(1e-3);
  m.shift = normal3(3e-3);
  m.zoom = 2e-3 * random.normal();
  const double px = random.normal(), py = random.normal();
  m.principal_point = {0.6 * px, 0.6 * py};
  return m;
}

RigCamera mistaken(const RigCamera& camera, const Mistake& m, double amount) {
  RigCamera result = camera;
  const Vector3d turn = amount * m.turn;
  const Eigen::Quaterniond rotation(
      Eigen::AngleAxisd(turn.norm(), turn.norm() > 0 ? Vector3d(turn.normalized()) : Vector3d::UnitX()));
  const Vector3d center = camera.cam_from_world.center() + amount * m.shift;
  result.cam_from_world.rotation = (rotation * camera.cam_from_world.rotation).normalized();
  result.cam_from_world.translation = -(result.cam_from_world.rotation * center);
  result.model.fx *= 1 + amount * m.zoom;
  result.model.fy *= 1 + amount * m.zoom;
  result.model.cx += amount * m.principal_point.x();
  result.model.cy += amount * m.principal_point.y();
  return result;
}

// Root mean square per image axis; 0 when the camera sees none of the points.
double projection_error(const RigCamera& a, const RigCamera& b) {
  double sum = 0;
  int count = 0;
  for (const Vector3d& p : performer_volume()) {
    const std::optional<Vector2d> pa = project(a.model, a.cam_from_world * p),
                                  pb = project(b.model, b.cam_from_world * p);
    if (!pa || !pb) continue;
    sum += (*pa - *pb).squaredNorm();
    count += 2;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace

std::vector<Vector3d> performer_volume() {
  std::vector<Vector3d> points;
  for (double x : {-0.5, -0.25, 0.0, 0.25, 0.5})
    for (double y : {-0.35, 0.0, 0.35})
      for (double z : {0.1, 0.5, 0.9, 1.3, 1.7}) points.emplace_back(x, y, z);
  return points;
}

Rig with_calibration_error(const Rig& rig, double error, std::uint64_t seed) {
  Rig published = rig;
  if (error == 0) return published;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    Random random(key(seed, kCalibrationKey, static_cast<int>(i), 0));
    const Mistake mistake = draw(random);
    double amount = 1;
    for (int round = 0; round < 6; ++round) {  // the error is nearly proportional to the amount
      const double now = projection_error(rig.cameras[i], mistaken(rig.cameras[i], mistake, amount));
      if (now == 0) break;
      amount *= error / now;
    }
    published.cameras[i] = mistaken(rig.cameras[i], mistake, amount);
  }
  return published;
}

}  // namespace floatstage::synthetic
