#include "core/synthetic/room.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/room_surfaces.h"

namespace floatstage::synthetic {

using Eigen::Vector3f;

Room::Room(const Rig& rig, SyntheticStage stage, std::uint64_t seed)
    : stage_(stage), seed_(static_cast<std::uint32_t>(mix(seed ^ 0xC107))) {
  double reach = 3, top = 3;
  for (const RigCamera& c : rig.cameras) {
    const Eigen::Vector3d center = c.cam_from_world.center();
    reach = std::max(reach, center.head<2>().cwiseAbs().maxCoeff());
    top = std::max(top, center.z());
  }
  const auto half = static_cast<float>(reach + 1);
  low_ = {-half, -half, 0};
  high_ = {half, half, static_cast<float>(top + 1.5)};
}

Vector3f Room::color(const Vector3f& origin, const Vector3f& direction) const {
  // Where the ray leaves the box: from inside that is what it sees; from outside, the near side is left open.
  float leaves = std::numeric_limits<float>::infinity(), enters = 0;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    if (direction[i] == 0) {
      if (origin[i] < low_[i] || origin[i] > high_[i]) return Vector3f::Zero();
      continue;
    }
    const float a = (low_[i] - origin[i]) / direction[i], b = (high_[i] - origin[i]) / direction[i];
    enters = std::max(enters, std::min(a, b));
    if (std::max(a, b) < leaves) {
      leaves = std::max(a, b);
      axis = i;
    }
  }
  if (!(leaves > enters)) return Vector3f::Zero();
  const Vector3f p = origin + leaves * direction;

  // Corners get less light: each neighbouring wall takes some away, over about half a metre.
  float light = 1;
  for (int i = 0; i < 3; ++i)
    if (i != axis) light *= 1 - 0.16f * std::exp(-std::min(p[i] - low_[i], high_[i] - p[i]) / 0.45f);
  light *= 0.94f + 0.12f * value_noise(p / 1.3f, seed_);
  if (axis == 2) {
    light *= 1.02f - 0.03f * p.head<2>().norm();  // the lamps hang over the middle
    light *= 1 + 0.03f * (value_noise(Vector3f(p.x() / 0.5f, p.y() / 0.12f, 0), seed_ + 1) - 0.5f);
  } else {
    light *= 0.86f + 0.05f * std::min(p.z(), 2.5f);
    // Folds hang down, wander sideways and get shallower towards the floor.
    const float along = axis == 0 ? p.y() : p.x() + 31;
    const float wander = 0.5f * value_noise({along / 0.9f, p.z() / 1.1f, 3}, seed_ + 2);
    const float depth = 0.055f * value_noise({along / 1.2f, p.z() / 2.0f, 7}, seed_ + 3);
    light *= 1 + depth * std::sin(6.2832f * (along / 0.38f + wander));
  }
  return room_surface(stage_,
                      {.position = p,
                       .axis = axis,
                       .floor = axis == 2 && direction.z() < 0,
                       .along = axis == 0 ? p.y() : p.x() + 31,
                       .light = light},
                      seed_);
}

}  // namespace floatstage::synthetic
