#include "render/zipmap/zipmap_needs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace floatstage::render {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Wrap = Zipmap::Wrap;

constexpr int kSide = 9;         // points of the view that are looked at, a side
constexpr double kMargin = 0.5;  // levels that a homography may be finer between them

AlignedBox2d whole() { return {Vector2d(0, 0), Vector2d(1, 1)}; }

// Where a rectangle comes to lie; absent when a part of it lies behind the horizon.
std::optional<AlignedBox2d> box_under(const Matrix3d& h, const Vector2d& low, const Vector2d& high) {
  AlignedBox2d box;
  for (const double x : {low.x(), high.x()})
    for (const double y : {low.y(), high.y()}) {
      const Vector3d p = h * Vector3d(x, y, 1);
      if (!(p.z() > kHorizon)) return std::nullopt;
      box.extend(p.hnormalized());
    }
  return box;
}

// What of the root a stretch of coordinates shows, an axis at a time.
AlignedBox2d folded(const AlignedBox2d& box, Wrap wrap) {
  AlignedBox2d out = whole();
  for (int k = 0; k < 2; ++k) {
    const double low = box.min()[k], high = box.max()[k];
    if (wrap != Wrap::Clamp && std::floor(low) != std::floor(high)) continue;
    const double a = wrapped(low, wrap), b = wrapped(high, wrap);
    out.min()[k] = std::min(a, b);
    out.max()[k] = std::max(a, b);
  }
  return out;
}

// A pixel of the view: where it shows the root, and its steps there.
struct Point {
  Vector2d uv;
  Eigen::Matrix2d step;
};

std::vector<Point> points_of(const ZipmapView& view) {
  std::vector<Point> points;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const Vector3d p = view.uv_from_pixel * Vector3d(0.5 + (view.width - 1.0) * i / (kSide - 1),
                                                       0.5 + (view.height - 1.0) * j / (kSide - 1), 1);
      if (!(p.z() > kHorizon)) continue;
      const Vector2d uv = p.hnormalized();
      points.push_back(
          {{wrapped(uv.x(), view.wrap), wrapped(uv.y(), view.wrap)}, step_under(view.uv_from_pixel, p)});
    }
  return points;
}

}  // namespace

std::vector<PatchNeed> needs_of(const Zipmap& zipmap, const ZipmapView& view) {
  const std::optional<AlignedBox2d> seen =
      box_under(view.uv_from_pixel, {0, 0}, Vector2d(view.width, view.height));
  const AlignedBox2d shown = seen ? folded(*seen, view.wrap) : whole();
  const std::vector<Point> points = points_of(view);
  const double each = static_cast<double>(view.width) * view.height / (kSide * kSide);
  std::vector<PatchNeed> needs;
  for (std::size_t i = 0; i < zipmap.patches().size(); ++i) {
    const Zipmap::Patch& patch = zipmap.patches()[i];
    const Matrix3d& m = patch.patch_from_root;
    const AlignedBox2d box = box_under(m.inverse(), {0, 0}, {1, 1}).value_or(whole());
    if (!box.intersects(shown)) continue;
    const MipPyramid& picture = zipmap.pictures()[patch.picture];
    double finest = static_cast<double>(picture.levels().size()), coarsest = -1e9, pixels = each;
    for (const Point& point : points) {
      const Vector2d at = point.uv.cwiseMax(box.min()).cwiseMin(box.max());
      const Vector3d p = m * at.homogeneous();
      if (!(p.z() > kHorizon)) continue;
      const Eigen::Matrix2d step = step_under(m, p) * point.step;
      const double lod = level_of_detail(picture, step.col(0), step.col(1));
      finest = std::min(finest, lod);
      coarsest = std::max(coarsest, lod);
      if (at == point.uv) pixels += each;
    }
    if (coarsest < -1e8 || coarsest - finest > 1e-6) finest -= kMargin;
    const double last = static_cast<double>(picture.levels().size() - 1);
    const bool unknown =
        points.size() < kSide * kSide || !seen;  // a horizon in the view: anything may be near
    needs.push_back(
        {i, unknown ? 0 : static_cast<std::size_t>(std::clamp(std::floor(finest), 0.0, last)), pixels});
  }
  return needs;
}

}  // namespace floatstage::render
