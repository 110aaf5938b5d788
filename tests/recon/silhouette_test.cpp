#include "recon/silhouette.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "recon/exact/silhouette_cones.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;

Matte picture(int width, int height, const auto& alpha) {
  Image image(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) *image.at(x, y) = static_cast<std::uint8_t>(alpha(x, y));
  }
  return make_matte({}, image);
}

Matte square(int left, int top, int side) {
  return picture(40, 30, [=](int x, int y) {
    return x >= left && x < left + side && y >= top && y < top + side ? 255 : 0;
  });
}

Silhouette traced(const Matte& matte, bool unknown_beyond = false) {
  SilhouetteScratch scratch;
  Silhouette out;
  trace_outline(matte, unknown_beyond, scratch, out);
  return out;
}

Matte noise(std::uint64_t seed, int width, int height, double density) {
  Random random(seed);
  return picture(width, height, [&](int, int) {
    return random.uniform() < density ? 128 + random.next() % 128 : random.next() % 128;
  });
}

double distance_to(const Silhouette& outline, const Vector2d& p) {
  double best = 1e9;
  for (int k = 0; k < outline.polygons(); ++k) {
    for (int i = outline.starts[k]; i < outline.starts[k + 1]; ++i) {
      const Vector2d a = outline.points[i],
                     b = outline.points[i + 1 < outline.starts[k + 1] ? i + 1 : outline.starts[k]];
      const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
      best = std::min(best, (p - a - t * (b - a)).norm());
    }
  }
  return best;
}

TEST(Silhouette, OfASquareHasItsSidesOnThePixelEdges) {
  // The corner of the image is (0,0): pixels 10 … 17 reach from 10 to 18.
  const Silhouette outline = traced(square(10, 5, 8));
  ASSERT_EQ(outline.polygons(), 1);
  EXPECT_FALSE(outline.beyond_counts);
  Eigen::AlignedBox2d box;
  for (const Vector2d& p : outline.points) box.extend(p);
  EXPECT_EQ(box.min(), Vector2d(10, 5));
  EXPECT_EQ(box.max(), Vector2d(18, 13));
  EXPECT_NEAR(enclosed_area(outline), 64 - 4 * 0.125, 1e-12) << "marching squares cuts the four corners";
}

TEST(Silhouette, RunsWithTheSubjectOnItsRightAndAroundHolesTheOtherWay) {
  const Matte frame = picture(40, 30, [](int x, int y) {
    const bool outer = x >= 5 && x < 25 && y >= 5 && y < 25, inner = x >= 10 && x < 20 && y >= 10 && y < 20;
    return outer && !inner ? 255 : 0;
  });
  const Silhouette outline = traced(frame);
  ASSERT_EQ(outline.polygons(), 2);
  EXPECT_NEAR(enclosed_area(outline), 300, 1);
}

TEST(Silhouette, FollowsPartialCoverageBelowAPixel) {
  // A half-plane whose edge cuts the pixels of column 20 at a fraction: alpha is the fraction covered.
  for (const double edge : {20.1, 20.3, 20.5, 20.8}) {
    const Matte matte = picture(40, 30, [&](int x, int y) {
      return y >= 2 && y < 28 && x >= 2 ? std::lround(255 * std::clamp(edge - x, 0.0, 1.0)) : 0;
    });
    double farthest = 0;
    for (const Vector2d& p : traced(matte).points) farthest = std::max(farthest, p.x());
    EXPECT_NEAR(farthest, edge, 0.2) << "interpolation between pixel centres";
  }
}

TEST(Silhouette, IsSimpleForAnyNoise) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Silhouette outline =
        traced(noise(seed, 50, 40, 0.2 + 0.02 * static_cast<double>(seed)), seed % 2 == 0);
    EXPECT_TRUE(is_simple(outline)) << seed;
    for (const double tolerance : {0.5, 1.0, 3.0}) {
      const Silhouette simple = simplify_outline(outline, tolerance);
      EXPECT_TRUE(is_simple(simple)) << seed << ", " << tolerance << " px";
      EXPECT_EQ(simple.polygons(), outline.polygons());
      EXPECT_LT(simple.points.size(), outline.points.size());
    }
  }
}

TEST(Silhouette, KeepsDiagonalNeighboursApart) {
  const Silhouette outline =
      traced(picture(10, 10, [](int x, int y) { return x == y && x > 2 && x < 6 ? 255 : 0; }));
  EXPECT_EQ(outline.polygons(), 3) << "a pinch is no connection";
  EXPECT_TRUE(is_simple(outline));
}

TEST(Silhouette, SimplifiedStaysWithinTheTolerance) {
  const Matte blob = picture(200, 160, [](int x, int y) {
    const double a = std::atan2(y - 80.0, x - 100.0), r = std::hypot(x - 99.7, y - 80.2);
    return std::clamp(128 + 128 * (50 + 12 * std::sin(7 * a) - r), 0.0, 255.0);
  });
  const Silhouette full = traced(blob);
  for (const double tolerance : {0.25, 0.5, 2.0}) {
    const Silhouette simple = simplify_outline(full, tolerance);
    EXPECT_LT(simple.points.size(), full.points.size() / 3);
    for (const Vector2d& p : full.points) EXPECT_LE(distance_to(simple, p), tolerance + 1e-9);
  }
}

TEST(Silhouette, DoesNotJumpOverASmallPolygonBesideALongEdge) {
  // A thin strand runs along the body, nearer to it than the tolerance.
  const Matte matte = picture(60, 40, [](int x, int y) {
    if (y >= 20 && y < 35 && x >= 5 && x < 55) return y == 20 && x % 7 == 3 ? 90 : 255;
    return y == 18 && x >= 12 && x < 45 ? 200 : 0;
  });
  const Silhouette full = traced(matte), simple = simplify_outline(full, 3);
  EXPECT_EQ(simple.polygons(), full.polygons());
  EXPECT_TRUE(is_simple(simple));
  const auto polygon_area = [](const Silhouette& outline, int k) {
    Silhouette one;
    one.points.assign(outline.points.begin() + outline.starts[k],
                      outline.points.begin() + outline.starts[k + 1]);
    one.starts = {0, static_cast<int>(one.points.size())};
    return enclosed_area(one);
  };
  for (int k = 0; k < full.polygons(); ++k) {
    EXPECT_GT(polygon_area(full, k) * polygon_area(simple, k), 0) << "polygon " << k << " turned inside out";
  }
}

TEST(Silhouette, CutByTheBorderBoundsTheBackgroundThatWasSeen) {
  const Silhouette outline = traced(square(-3, 5, 10));
  EXPECT_TRUE(outline.beyond_counts);
  EXPECT_NEAR(enclosed_area(outline), -(40 * 30 - 70), 3) << "all that is known not to be subject";
  for (const Vector2d& p : outline.points) {
    EXPECT_TRUE(p.x() >= 0 && p.y() >= 0 && p.x() <= 40 && p.y() <= 30);
  }
  EXPECT_TRUE(is_simple(outline));
}

TEST(Silhouette, OfNothingBoundsTheWholePicture) {
  const Silhouette outline = traced(picture(40, 30, [](int, int) { return 0; }));
  EXPECT_TRUE(outline.beyond_counts);
  EXPECT_NEAR(enclosed_area(outline), -1200, 1);
}

TEST(Silhouette, OfEverythingIsEmpty) {
  EXPECT_TRUE(traced(picture(40, 30, [](int, int) { return 255; })).empty());
  EXPECT_TRUE(traced(Matte{}).empty());
}

TEST(Silhouette, LosesTheLensFromItsPointsAndStaysSimple) {
  CameraModel model;
  model.width = 200;
  model.height = 160;
  model.fx = model.fy = 150;
  model.cx = 101;
  model.cy = 78;
  model.lens = BrownConrady{-0.2, 0.05, 1e-3, -2e-3, 0};
  // A straight bar in the world is bent in the picture and straight again afterwards.
  const auto in_bar = [&](const Vector2d& pixel) {
    const auto ray = unproject(model, pixel);
    return ray && std::abs(ray->x()) < 0.4 && ray->y() > 0.3 && ray->y() < 0.4;
  };
  const Matte matte = picture(model.width, model.height, [&](int x, int y) {
    int hits = 0;
    for (int s = 0; s < 64; ++s) hits += in_bar({x + (s % 8 + 0.5) / 8, y + (s / 8 + 0.5) / 8});
    return 255 * hits / 64;
  });
  SilhouetteScratch scratch;
  Silhouette outline;
  undistorted_outline(matte, model, lens_bend(model), {.tolerance = 0.25}, scratch, outline);
  ASSERT_EQ(outline.polygons(), 1);
  EXPECT_TRUE(is_simple(outline));
  const double top = model.cy + 150 * 0.3, bottom = model.cy + 150 * 0.4;
  for (const Vector2d& p : outline.points) {
    if (std::abs(p.x() - model.cx) > 58) continue;  // the bar's ends
    EXPECT_LT(std::min(std::abs(p.y() - top), std::abs(p.y() - bottom)), 0.6);
  }
  EXPECT_NEAR(enclosed_area(outline), 120 * 15, 0.01 * 120 * 15);
}

TEST(SilhouetteCones, HaveRaysThroughTheContourPoints) {
  Rig rig;
  RigCamera camera;
  camera.serial = "a";
  camera.model = {.width = 40, .height = 30, .fx = 50, .fy = 52, .cx = 19, .cy = 16, .skew = 0, .lens = {}};
  camera.cam_from_world = look_at({2, 1, 1}, {0, 0, 0}, {0, 0, 1});
  rig.cameras = {camera, camera};
  rig.cameras[1].serial = "b";
  ConeBuilder builder;
  SilhouetteCones cones;
  const std::vector<Matte> mattes = {square(10, 5, 8), Matte{}};
  builder.build(rig, HullInput(rig, std::span<const Matte>(mattes), 1), {}, cones);
  ASSERT_EQ(cones.views.size(), 1u) << "a camera without a matte has no cone";
  EXPECT_EQ(cones.camera[0], 0);
  EXPECT_NEAR((cones.views[0].center - Eigen::Vector3d(2, 1, 1)).norm(), 0, 1e-12);
  for (std::size_t k = 0; k < cones.views[0].rays.size(); ++k) {
    const Eigen::Vector3d point = cones.views[0].center + 3 * cones.views[0].rays[k];
    const auto pixel = project(camera.model, camera.cam_from_world * point);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR((*pixel - cones.outlines[0].points[k]).norm(), 0, 1e-9);
  }
}

}  // namespace
}  // namespace floatstage::recon
