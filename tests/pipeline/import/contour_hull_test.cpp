// Contours that another program found exactly must carve what they say, to a fraction of a pixel.
#include <cmath>

#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "core/synthetic/synthetic_studio.h"
#include "pipeline/import/contours.h"
#include "recon/outline.h"
#include "recon/visual_hull.h"
#include "tests/pipeline/import/contour_support.h"
#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = std::vector<Vector2d>;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// The outline of a convex body is the convex hull of its corners' pictures.
Polygon hull_of(Polygon points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  Polygon hull;
  for (const bool back : {false, true}) {
    const std::size_t begin = hull.size();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d& p = points[back ? points.size() - 1 - i : i];
      while (hull.size() >= begin + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
  }
  return hull;
}

/// Share of each pixel that the polygon covers, by 16 × 16 samples: how mattes are usually made of polygons.
Image covered(const PictureContours& contours) {
  constexpr int kFine = 16;
  PictureContours fine = contours;
  Silhouette outline;
  for (Vector2d& p : fine.shapes[0].polygons[0]) outline.points.push_back(kFine * p);
  outline.starts = {0, static_cast<int>(outline.points.size())};
  const Matte samples = recon::filled(outline, kFine * contours.width, kFine * contours.height);
  Image alpha(contours.width, contours.height, 1);
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x) {
      int inside = 0;
      for (int v = 0; v < kFine; ++v)
        for (int u = 0; u < kFine; ++u) inside += samples.row(kFine * y + v)[kFine * x + u] > 0 ? 1 : 0;
      *alpha.at(x, y) = static_cast<std::uint8_t>(std::lround(255.0 * inside / (kFine * kFine)));
    }
  return alpha;
}

TEST(ContourMattes, CarveWhatTheContoursCarve) {
  const Rig rig = synthetic_rig({.shape = RigShape::Ring, .cameras = 6, .width = 160, .height = 120});
  std::vector<Vector3d> corners;
  for (int i = 0; i < 40; ++i) {
    const double z = -1 + 2 * (i + 0.5) / 40, r = std::sqrt(1 - z * z), a = 2.39996 * i;
    corners.emplace_back(0.35 * r * std::cos(a), 0.25 * r * std::sin(a), 1 + 0.6 * z);
  }
  std::vector<Silhouette> exact;
  std::vector<Matte> ours, usual;
  for (const RigCamera& camera : rig.cameras) {
    Polygon seen;
    for (const Vector3d& p : corners) seen.push_back(*project(camera.model, camera.cam_from_world * p));
    const PictureContours contours{"", camera.model.width, camera.model.height, {{"body", {hull_of(seen)}}}};
    const Polygon& outline = contours.shapes[0].polygons[0];
    exact.push_back({outline, {0, static_cast<int>(outline.size())}, false});
    ours.push_back(make_matte({}, matte_of(contours)));
    usual.push_back(make_matte({}, covered(contours)));
  }
  recon::HullOptions options;
  options.contour_tolerance = 0;
  const auto truth = recon::visual_hull(rig, std::span<const Silhouette>(exact), options),
             made = recon::visual_hull(rig, std::span<const Matte>(ours), options),
             other = recon::visual_hull(rig, std::span<const Matte>(usual), options);
  ASSERT_THAT(truth, IsOk());
  ASSERT_THAT(made, IsOk());
  ASSERT_THAT(other, IsOk());
  const double off = std::abs(made->volume / truth->volume - 1),
               usually = std::abs(other->volume / truth->volume - 1);
  RecordProperty("off", std::to_string(off));
  RecordProperty("usually", std::to_string(usually));
  EXPECT_LT(off, 0.002);
  EXPECT_LE(off, usually + 1e-4);
  for (const double iou : made->silhouette_iou) EXPECT_GT(iou, 0.99);
}

}  // namespace
}  // namespace floatstage::pipeline
