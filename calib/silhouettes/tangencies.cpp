// Method:  epipolar tangents of outlines, outermost ones
// Paper:   J. Porrill, S. Pollard, "Curve matching and stereo calibration", 1991; R. Cipolla, K. Åström,
//          P. Giblin, "Motion from the frontier of curved surfaces", 1995
// Differs: only tangents of the outlines' convex hulls, which no occlusion hides and no search has to match
// ADR:     0235

#include "calib/silhouettes/tangencies.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace floatstage::calib {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSpeck = 0.02;  // of the largest island's area
constexpr double kBorder = 1.5;  // px: an outline this near to the picture's border is cut by it

struct Point {
  Vector2d at;
  bool cut;
};

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double area_of(const Silhouette& outline, int polygon) {
  const int begin = outline.starts[static_cast<std::size_t>(polygon)],
            end = outline.starts[static_cast<std::size_t>(polygon) + 1];
  double twice = 0;
  for (int i = begin; i < end; ++i)
    twice += cross(outline.points[static_cast<std::size_t>(i)],
                   outline.points[static_cast<std::size_t>(i + 1 < end ? i + 1 : begin)]);
  return 0.5 * std::abs(twice);
}

bool at_border(const CameraModel& model, const Vector2d& p) {
  return p.x() < kBorder || p.y() < kBorder || p.x() > model.width - kBorder ||
         p.y() > model.height - kBorder;
}

// Andrew's monotone chain.
std::vector<Point> convex_hull(std::vector<Point> points) {
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return a.at.x() < b.at.x() || (a.at.x() == b.at.x() && a.at.y() < b.at.y());
  });
  std::vector<Point> hull;
  for (const bool back : {false, true}) {
    const std::size_t begin = hull.size();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point& p = points[back ? points.size() - 1 - i : i];
      while (hull.size() >= begin + 2 &&
             cross(hull.back().at - hull[hull.size() - 2].at, p.at - hull.back().at) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    if (!hull.empty()) hull.pop_back();  // begins the other half
  }
  return hull;
}

// Points of the outline that say where the subject ends, and those where it may go on. A subject that is cut
// is told by the background's polygons: what of them lies along the border says nothing, but where they leave
// it.
void collect(const CameraModel& model, const Silhouette& outline, int polygon, std::vector<Point>& out) {
  const int begin = outline.starts[static_cast<std::size_t>(polygon)],
            end = outline.starts[static_cast<std::size_t>(polygon) + 1], count = end - begin;
  const auto point = [&](int i) -> const Vector2d& {
    return outline.points[static_cast<std::size_t>(begin + (i + count) % count)];
  };
  for (int i = 0; i < count; ++i) {
    const bool cut = at_border(model, point(i));
    const bool inner = !cut || !at_border(model, point(i - 1)) || !at_border(model, point(i + 1));
    if (outline.beyond_counts && !inner) continue;
    const auto ray = unproject(model, point(i));
    if (ray) out.push_back({ray->head<2>(), cut});
  }
}

}  // namespace

ConvexOutline convex_outline(const CameraModel& model, const Silhouette& outline) {
  ConvexOutline out;
  double largest = 0;
  for (int k = 0; k < outline.polygons(); ++k) largest = std::max(largest, area_of(outline, k));
  std::vector<Point> points;
  for (int k = 0; k < outline.polygons(); ++k)
    if (area_of(outline, k) >= kSpeck * largest) collect(model, outline, k, points);
  if (points.size() < 3) return out;
  for (const Point& p : convex_hull(std::move(points))) {
    out.rays.push_back(p.at.homogeneous());
    out.cut.push_back(p.cut);
  }
  return out;
}

std::optional<PlanePencil> PlanePencil::through(const RigCamera& a, const RigCamera& b,
                                                const Vector3d& towards) {
  PlanePencil pencil;
  pencil.base_ = b.cam_from_world.center() - a.cam_from_world.center();
  if (!(pencil.base_.norm() > 0)) return std::nullopt;
  pencil.base_.normalize();
  pencil.zero_ = towards - pencil.base_ * pencil.base_.dot(towards);
  if (!(pencil.zero_.norm() > 1e-6 * towards.norm())) return std::nullopt;
  pencil.zero_.normalize();
  pencil.across_ = pencil.base_.cross(pencil.zero_);
  return pencil;
}

double PlanePencil::angle_of(const Vector3d& ray) const {
  return std::atan2(ray.dot(across_), ray.dot(zero_));
}

double PlanePencil::angle_per_pixel(const RigCamera& camera, const Vector3d& ray) const {
  const double off_base = (camera.cam_from_world.rotation.conjugate() * ray).cross(base_).norm();
  return 1 / (0.5 * (camera.model.fx + camera.model.fy) * off_base);  // the ray's z is 1
}

std::optional<Extremes> PlanePencil::extremes(const RigCamera& camera, const ConvexOutline& outline) const {
  if (outline.empty()) return std::nullopt;
  const Eigen::Matrix3d world_from_cam = camera.cam_from_world.rotation.conjugate().toRotationMatrix();
  Extremes out;
  double previous = 0;
  for (std::size_t i = 0; i < outline.rays.size(); ++i) {
    // Unrolled along the hull: an outline around the other centre goes all the way round.
    double angle = angle_of(world_from_cam * outline.rays[i]);
    if (i > 0) angle = previous + std::remainder(angle - previous, 2 * std::numbers::pi);
    previous = angle;
    const auto note = [&](int side, bool further) {
      if (i > 0 && !further) return;
      out.angle[side] = angle;
      out.ray[side] = static_cast<int>(i);
    };
    note(0, angle < out.angle[0]);
    note(1, angle > out.angle[1]);
  }
  if (out.angle[1] - out.angle[0] > 0.9 * std::numbers::pi) return std::nullopt;
  for (int& ray : out.ray)
    if (outline.cut[static_cast<std::size_t>(ray)] != 0) ray = -1;
  return out;
}

}  // namespace floatstage::calib
