// Up, scale and floor of a rig's world. docs/adr/0240-worlds-by-what-is-known.md

#include "pipeline/world.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "pipeline/ring.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;

double rounded(double v) { return std::round(v * 100) / 100 + 0.0; }

Vector3d up_named(const std::string& name, const Rig& rig) {
  if (name == "ring") return up_axis(rig).direction;
  const double sign = name.front() == '-' ? -1 : 1;
  return sign * Vector3d::Unit(name.back() - 'x');
}

}  // namespace

std::vector<std::string> up_names() { return {"x", "-x", "y", "-y", "z", "-z", "ring"}; }

Rig in_world(const Rig& rig, const WorldChange& new_from_old) {
  Rig moved = rig;
  for (RigCamera& c : moved.cameras) {
    Rigid3& t = c.cam_from_world;
    t.rotation = (t.rotation * new_from_old.rotation.conjugate()).normalized();
    t.translation = new_from_old.scale * t.translation - t.rotation * new_from_old.translation;
  }
  return moved;
}

Result<WorldChange> world_change(const Rig& rig, const WorldOptions& options) {
  WorldChange change;
  change.scale = options.scale.value_or(1);
  if (!(change.scale > 0) || !std::isfinite(change.scale))
    return fail(ErrorCode::InvalidArgument, text("a scale of ", change.scale,
                                                 " makes no world; say how many "
                                                 "metres one of its units is"));
  if (!options.up.empty()) {
    const Vector3d up = up_named(options.up, rig);
    change.rotation = Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ());
  }
  if (options.up == "ring") {
    const Rig turned = in_world(rig, change);
    const Ring ring = fit_ring(turned, Vector3d::UnitZ());
    const Vector3d middle = ring.center_error < 0.5 * ring.radius ? ring.center : focus_point(turned);
    change.translation -= Vector3d(middle.x(), middle.y(), 0);
  }
  if (options.floor) change.translation.z() -= *options.floor;
  return change;
}

std::string describe_world(const Rig& rig) {
  double low = rig.cameras.front().cam_from_world.center().z(), high = low, away = 0;
  const Vector3d focus = focus_point(rig);
  for (const RigCamera& c : rig.cameras) {
    const Vector3d center = c.cam_from_world.center();
    low = std::min(low, center.z()), high = std::max(high, center.z());
    away += (center - focus).norm() / static_cast<double>(rig.cameras.size());
  }
  std::string out =
      text("in metres, z up and the floor at z = 0, the cameras stand ", rounded(away),
           " m from what they look at, at heights of ", rounded(low), " to ", rounded(high), " m");
  const UpAxis up = up_axis(rig);
  if (up.direction.z() < std::cos(0.2))
    out += text("; their pictures show (", rounded(up.direction.x()), ", ", rounded(up.direction.y()), ", ",
                rounded(up.direction.z()), ") as up, not z: --up ring turns the world");
  return out;
}

}  // namespace floatstage::pipeline
