#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/check.h"
#include "core/synthetic/synthetic_studio.h"

namespace floatstage {
namespace {

constexpr double kPi = std::numbers::pi;
const Eigen::Vector3d kMiddle(0, 0, 1.0);                // of the performer
constexpr double kHalfHeight = 1.06, kHalfWidth = 0.95;  // metres around the middle that every picture shows
constexpr double kStep = 0.85;                           // metres that two walk away from the middle

Eigen::Vector3d eye(const SyntheticRigOptions& o, int i) {
  if (o.shape == RigShape::Ring) {
    const double azimuth = 2 * kPi * i / o.cameras;
    return {o.distance * std::sin(azimuth), o.distance * std::cos(azimuth), o.height_above_floor};
  }
  // Rows one above the other over a quarter of the circle in front, as even as the number allows; the lower
  // rows get the remainder.
  const int rows = std::max(1, static_cast<int>(std::lround(std::sqrt(o.cameras / 2.0))));
  int row = 0, first = 0, in_row = 0;
  for (;; first += in_row, ++row) {
    in_row = o.cameras / rows + (row < o.cameras % rows);
    if (i < first + in_row) break;
  }
  const double azimuth = in_row > 1 ? kPi / 2 * (static_cast<double>(i - first) / (in_row - 1) - 0.5) : 0;
  const double lowest = std::asin(std::clamp((o.height_above_floor - kMiddle.z()) / o.distance, -0.9, 0.9));
  const double elevation = rows > 1 ? lowest + (kPi / 4 - lowest) * row / (rows - 1) : lowest;
  return kMiddle + o.distance * Eigen::Vector3d(std::sin(azimuth) * std::cos(elevation),
                                                std::cos(azimuth) * std::cos(elevation), std::sin(elevation));
}

}  // namespace

Rig synthetic_rig(const SyntheticRigOptions& o) {
  FLOATSTAGE_CHECK(o.cameras > 0 && o.width > 0 && o.height > 0, "a rig without cameras or pixels");
  FLOATSTAGE_CHECK(std::isfinite(o.distance) && o.distance > (o.cast == SyntheticCast::One ? 1 : 2) &&
                       std::isfinite(o.height_above_floor),
                   "cameras inside the performer");
  Rig rig;
  for (int i = 0; i < o.cameras; ++i) {
    const Eigen::Vector3d from = eye(o, i);
    const double step = o.cast == SyntheticCast::One ? 0 : kStep;
    const double distance = (from - kMiddle).norm() - 0.25 - step;  // an arm reaches towards the camera
    const double focal =
        distance * std::min(o.height / 2.0 / kHalfHeight, o.width / 2.0 / (kHalfWidth + step));
    char serial[16];
    std::snprintf(serial, sizeof serial, "cam%02d", i);
    RigCamera camera;
    camera.serial = serial;
    camera.model = {.width = o.width,
                    .height = o.height,
                    .fx = focal,
                    .fy = focal,
                    .cx = o.width / 2.0,
                    .cy = o.height / 2.0,
                    .lens = {}};
    camera.cam_from_world = look_at(from, kMiddle, Eigen::Vector3d::UnitZ());
    rig.cameras.push_back(camera);
  }
  return rig;
}

}  // namespace floatstage
