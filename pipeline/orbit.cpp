// Orbits on the cameras' own circle, framed on the silhouettes. docs/adr/0238-orbits-follow-the-ring.md

#include "pipeline/orbit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"
#include "core/text.h"
#include "pipeline/ring.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;
constexpr double kFree = 0.1;    // of the picture, on each side of the subject
constexpr int kStepsATurn = 72;  // keys; between them the spline leaves the circle by 1e-6 of its radius
constexpr double kMaxFov = 150;  // degrees: farther back is better than wider

double median(std::vector<double> v) {
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

// A place on the circle: angles about the axis through its middle.
struct Circle {
  Vector3d up, east, north, middle;  // the middle at the subject's height
  double distance = 0, height = 0;

  double azimuth_of(const Vector3d& p) const {
    return std::atan2((p - middle).dot(north), (p - middle).dot(east));
  }
  Vector3d at(double azimuth) const {
    return middle + (east * std::cos(azimuth) + north * std::sin(azimuth)) * distance + up * height;
  }
};

// The circle's middle is that of the cameras when it is known more exactly than the subject stands off it.
Circle circle_of(const Rig& rig, const Vector3d& up, const Vector3d& target, const OrbitOptions& options) {
  Circle c;
  c.up = up;
  c.east = c.up.unitOrthogonal();
  c.north = c.up.cross(c.east);
  const Ring ring = fit_ring(rig, c.up);
  const Vector3d to_ring = ring.center - target, level = to_ring - c.up * to_ring.dot(c.up);
  c.middle =
      2 * ring.center_error < level.norm() && level.norm() < ring.radius ? Vector3d(target + level) : target;
  std::vector<double> elevations, distances;
  for (const RigCamera& camera : rig.cameras) {
    const Vector3d d = camera.cam_from_world.center() - c.middle;
    elevations.push_back(std::atan2(d.dot(c.up), (d - c.up * d.dot(c.up)).norm()));
    distances.push_back(d.norm());
  }
  const double elevation = median(elevations), away = median(distances);
  c.distance = options.distance.value_or(away * std::cos(elevation));
  c.height = options.height.value_or(away * std::sin(elevation));
  return c;
}

// Where the cameras stand on the circle: the widest stretch without one decides, more than a third of a turn
// is the back of the stage.
struct Arc {
  double begin = 0, length = 2 * kPi;
  bool full_turn = true;
};

Arc arc_of(const Rig& rig, const Circle& circle) {
  std::vector<double> azimuths;
  for (const RigCamera& c : rig.cameras) azimuths.push_back(circle.azimuth_of(c.cam_from_world.center()));
  std::sort(azimuths.begin(), azimuths.end());
  double widest = 0;
  Arc arc;
  for (std::size_t i = 0; i < azimuths.size(); ++i) {
    const bool last = i + 1 == azimuths.size();
    const double next = last ? azimuths.front() + 2 * kPi : azimuths[i + 1];
    if (next - azimuths[i] > widest) widest = next - azimuths[i], arc.begin = next;
  }
  arc.full_turn = widest < 2 * kPi / 3;
  arc.length = 2 * kPi - widest;
  return arc;
}

double azimuth_at(const Arc& arc, double s, const OrbitOptions& o) {
  const double start = o.start * kPi / 180, turned = 2 * kPi * o.turns * s;
  if (arc.full_turn) return arc.begin + start + turned;
  const double share = arc.length > 0 ? std::clamp(start / arc.length, 0.0, 1.0) : 0;
  return arc.begin + arc.length * (1 - std::cos(std::acos(1 - 2 * share) + turned)) / 2;
}

// What of a picture the subject takes: tangents of the angles to the sides of its silhouette.
struct Extent {
  Eigen::AlignedBox2d box;
  double depth = 0;  // of the point that the picture is aimed at
};

Extent extent_in(const Rigid3& view_from_world, const Vector3d& aim, const Subject& subject) {
  Extent e{{}, (view_from_world * aim).z()};
  for (const Vector3d& p : subject.outermost) {
    const Vector3d in = view_from_world * p;
    if (in.z() > 0.01 * e.depth) e.box.extend(Eigen::Vector2d(in.x() / in.z(), in.y() / in.z()));
  }
  return e;
}

// The point to aim at that brings the silhouettes to the middle on the average, and the tangent of half the
// vertical field of view that holds all of them.
std::pair<Vector3d, double> framed(const std::vector<Vector3d>& eyes, const Vector3d& up, Vector3d aim,
                                   const Subject& subject, double aspect) {
  double tangent = 0;
  constexpr int kRounds = 6;  // each leaves less than half of what was off
  for (int round = 0; round < kRounds; ++round) {
    Vector3d off = Vector3d::Zero();
    tangent = 0;
    for (const Vector3d& eye : eyes) {
      const Rigid3 view_from_world = look_at(eye, aim, up);
      const Extent e = extent_in(view_from_world, aim, subject);
      if (e.box.isEmpty()) continue;
      const Eigen::Vector2d middle = e.box.center() * e.depth;
      off += view_from_world.rotation.conjugate() * Vector3d(middle.x(), middle.y(), 0);
      for (const Eigen::Vector2d& corner : {e.box.min(), e.box.max()})
        tangent = std::max({tangent, std::abs(corner.y()), std::abs(corner.x()) / aspect});
    }
    if (round + 1 < kRounds) aim += off / static_cast<double>(eyes.size());
  }
  return {aim, tangent / (1 - 2 * kFree)};
}

double mean_half_tangent(const Rig& rig) {
  double sum = 0;
  for (const RigCamera& c : rig.cameras) sum += c.model.height / (2 * c.model.fy);
  return sum / static_cast<double>(rig.cameras.size());
}

}  // namespace

Orbit orbit_around(const Rig& rig, const Subject& subject, const OrbitOptions& options) {
  FLOATSTAGE_CHECK(!rig.cameras.empty(), "an orbit around no cameras");
  const UpAxis up = up_axis(rig);
  Vector3d aim = subject.box.isEmpty() ? focus_point(rig) : subject.box.center();
  const Circle circle = circle_of(rig, up.direction, aim, options);
  const Arc arc = arc_of(rig, circle);
  const int steps = std::max(kStepsATurn, static_cast<int>(std::ceil(kStepsATurn * std::abs(options.turns))));
  std::vector<Vector3d> eyes;
  for (int i = 0; i <= steps; ++i)
    eyes.push_back(circle.at(azimuth_at(arc, static_cast<double>(i) / steps, options)));
  // Cameras that all face one way look at a scene, which fills their pictures, not at a subject.
  const bool frames = !subject.outermost.empty() && up.from != UpAxis::From::MeanUp;
  double tangent = mean_half_tangent(rig);
  if (frames) std::tie(aim, tangent) = framed(eyes, circle.up, aim, subject, options.aspect);
  Orbit orbit{{},
              circle.up,
              circle.height,
              circle.distance,
              options.fov.value_or(std::min(kMaxFov, 2 * std::atan(tangent) * 180 / kPi)),
              arc.full_turn ? 360 : arc.length * 180 / kPi};
  for (std::size_t i = 0; i < eyes.size(); ++i)
    orbit.path.keys.push_back({.time = static_cast<double>(i) / steps * options.seconds,
                               .eye = eyes[i],
                               .target = aim,
                               .up = circle.up,
                               .fov_y = orbit.fov});
  return orbit;
}

std::string describe(const Orbit& o) {
  auto rounded = [](double v) { return std::round(v * 100) / 100 + 0.0; };
  return text("orbit: around (", rounded(o.axis.x()), ", ", rounded(o.axis.y()), ", ", rounded(o.axis.z()),
              "), ", rounded(o.distance), " m from it and ", rounded(o.height),
              " m above the subject's middle, ", rounded(o.fov), " degrees high, ",
              o.covered < 360 ? text("there and back through ", std::round(o.covered), " degrees")
                              : std::string("all around"));
}

}  // namespace floatstage::pipeline
