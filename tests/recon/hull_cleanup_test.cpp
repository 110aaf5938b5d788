#include "recon/mesh/hull_cleanup.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "recon/mask_distance.h"
#include "recon/mesh/mesh_check.h"
#include "recon/mesh/mesh_mask.h"
#include "recon/mesh/slivers.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::Le;

MATCHER(IsClosed, "is closed, manifold and outward") {
  const MeshCheck check = check_mesh(arg);
  *result_listener << check.summary();
  return check.watertight && check.manifold && check.oriented && check.outward;
}

struct Scene {
  Rig rig;
  std::vector<Matte> mattes;
};

Scene scene_of(const shapes::Shape& shape, int cameras = 12) {
  Scene scene;
  scene.rig = shapes::sphere_rig({.cameras = cameras, .focal = 180});
  scene.mattes = shapes::render_mattes(scene.rig, shape);
  return scene;
}

HullReport hull_of(const Scene& scene, const MeshCleanup& cleanup, HullMethod method = HullMethod::Exact) {
  HullOptions options;
  options.method = method;
  options.resolution = 64;
  options.contour_tolerance = 0.1;
  options.cleanup = cleanup;
  Result<HullReport> hull = visual_hull(scene.rig, scene.mattes, options);
  EXPECT_THAT(hull, IsOk());
  return hull ? std::move(*hull) : HullReport{};
}

std::vector<std::pair<const char*, Scene>> bodies() {
  return {{"sphere", scene_of(shapes::sphere({0.1, 0, 0}, 0.5))},
          {"torus", scene_of(shapes::torus({0, 0, 0}, 0.4, 0.13), 20)},
          {"box", scene_of(shapes::box({0, 0, 0}, {0.7, 0.5, 0.6}))},
          {"two bodies", scene_of(shapes::both(shapes::sphere({-0.4, 0, 0}, 0.25),
                                               shapes::box({0.4, 0.1, 0}, {0.3, 0.3, 0.3})),
                                  16)}};
}

/// Every vertex of `cleaned` lies where some vertex of `hull` was, seen from every camera, within `px`; and
/// the other way round.
double furthest_vertex(const Scene& scene, const Mesh& from, const Mesh& to) {
  std::vector<std::vector<Vector2d>> seen(scene.rig.cameras.size());
  const auto see = [&](std::size_t c, const Eigen::Vector3f& p) {
    return *project(scene.rig.cameras[c].model, scene.rig.cameras[c].cam_from_world * p.cast<double>());
  };
  for (std::size_t c = 0; c < seen.size(); ++c)
    for (const Eigen::Vector3f& p : to.positions) seen[c].push_back(see(c, p));
  double furthest = 0;
  for (const Eigen::Vector3f& p : from.positions) {
    std::vector<Vector2d> here;
    for (std::size_t c = 0; c < seen.size(); ++c) here.push_back(see(c, p));
    double nearest = 1e9;
    for (std::size_t v = 0; v < to.positions.size(); ++v) {
      double worst = 0;
      for (std::size_t c = 0; c < seen.size() && worst < nearest; ++c)
        worst = std::max(worst, (seen[c][v] - here[c]).norm());
      nearest = std::min(nearest, worst);
    }
    furthest = std::max(furthest, nearest);
  }
  return furthest;
}

TEST(MeshCleanup, LeavesAHullAloneUnlessAsked) {
  const Scene scene = scene_of(shapes::sphere({0, 0, 0}, 0.5));
  const HullReport hull = hull_of(scene, {});
  EXPECT_FALSE(hull.cleanup);
  EXPECT_EQ(hull.timings.cleanup, 0);
}

TEST(MeshCleanup, CollapsesSliversAndNoVertexMovesByMoreThanHalfAPixelInAnyView) {
  for (const auto& [name, scene] : bodies()) {
    const HullReport raw = hull_of(scene, {}), cleaned = hull_of(scene, {.collapse_slivers = true});
    ASSERT_TRUE(cleaned.cleanup) << name;
    EXPECT_THAT(cleaned.mesh, IsClosed()) << name;
    EXPECT_EQ(check_mesh(cleaned.mesh).genus, check_mesh(raw.mesh).genus) << name;
    EXPECT_EQ(check_mesh(cleaned.mesh).shells, check_mesh(raw.mesh).shells) << name;
    EXPECT_EQ(cleaned.cleanup->triangles_before, raw.mesh.triangle_count()) << name;
    EXPECT_EQ(cleaned.cleanup->triangles_after, cleaned.mesh.triangle_count()) << name;
    EXPECT_LT(cleaned.cleanup->slivers_after, 0.7 * static_cast<double>(cleaned.cleanup->slivers_before))
        << name;
    EXPECT_THAT(cleaned.cleanup->vertex_move, Each(Le(0.501))) << name;
    EXPECT_LE(furthest_vertex(scene, raw.mesh, cleaned.mesh), 0.501) << name << ": counted anew";
    EXPECT_EQ(furthest_vertex(scene, cleaned.mesh, raw.mesh), 0) << name << ": no vertex is new";
    EXPECT_NEAR(cleaned.volume / raw.volume, 1, 0.005) << name;
    EXPECT_NEAR(cleaned.volume / signed_volume(cleaned.mesh), 1, 1e-9) << name;
  }
}

TEST(MeshCleanup, MovesNothingWithinNoPixels) {
  const Scene scene = scene_of(shapes::torus({0, 0, 0}, 0.4, 0.13));
  const HullReport raw = hull_of(scene, {});
  const HullReport cleaned = hull_of(scene, {.collapse_slivers = true, .smooth = 3, .largest_move = 0});
  EXPECT_LE(furthest_vertex(scene, raw.mesh, cleaned.mesh), 1e-4);
  EXPECT_THAT(cleaned.cleanup->silhouette_shift, Each(0.0));
}

TEST(MeshCleanup, DecimatesToItsBudgetAndSaysHowFarTheSilhouettesShifted) {
  for (const auto& [name, scene] : bodies()) {
    const HullReport raw = hull_of(scene, {});
    double last = -1;
    for (const double share : {0.5, 0.1}) {
      const int budget = static_cast<int>(share * static_cast<double>(raw.mesh.triangle_count()));
      const HullReport cleaned = hull_of(scene, {.triangles = budget});
      ASSERT_TRUE(cleaned.cleanup) << name;
      EXPECT_THAT(cleaned.mesh, IsClosed()) << name;
      EXPECT_EQ(check_mesh(cleaned.mesh).genus, check_mesh(raw.mesh).genus) << name;
      EXPECT_EQ(check_mesh(cleaned.mesh).shells, check_mesh(raw.mesh).shells) << name;
      EXPECT_LE(cleaned.mesh.triangle_count(), static_cast<std::size_t>(budget)) << name;
      double furthest = 0;
      for (std::size_t c = 0; c < scene.rig.cameras.size(); ++c) {
        const double shift = mask_distance(mesh_mask(scene.rig.cameras[c], raw.mesh),
                                           mesh_mask(scene.rig.cameras[c], cleaned.mesh));
        EXPECT_EQ(cleaned.cleanup->silhouette_shift[c], shift) << name;
        furthest = std::max(furthest, shift);
      }
      EXPECT_LE(furthest, share > 0.2 ? 1.5 : 4.5) << name << " at " << share;
      EXPECT_GE(furthest, last) << name << ": fewer triangles are no better";
      last = furthest;
    }
  }
}

TEST(MeshCleanup, KeepsShellsAndHandlesWhenTheBudgetIsTooSmallForThem) {
  const Scene scene = scene_of(shapes::torus({0, 0, 0}, 0.4, 0.13), 20);
  const HullReport cleaned = hull_of(scene, {.triangles = 4});
  EXPECT_THAT(cleaned.mesh, IsClosed());
  EXPECT_EQ(check_mesh(cleaned.mesh).genus, 1);
  EXPECT_GT(cleaned.mesh.triangle_count(), 13u) << "no torus has fewer than 14";
  EXPECT_THAT(cleaned.remarks, Contains(HasSubstr("decimation stopped at")));
}

// Strands of hair make a loop of the surface each, which decimation keeps.
TEST(MeshCleanup, TakesGapsOutOfTheSilhouettesForABudgetThatCannotHoldThem) {
  Scene scene = scene_of(shapes::sphere({0, 0, 0}, 0.5), 8);
  std::vector<Matte> plain = scene.mattes;
  for (std::size_t c = 0; c < scene.mattes.size(); ++c) {
    Image holes = to_image(plain[c]);
    for (int y = 0; y < holes.height; ++y)
      for (int x = 0; x < holes.width; ++x)
        if (x % 16 < 2 && y % 16 < 2) *holes.at(x, y) = 0;
    scene.mattes[c] = make_matte({}, holes);
  }
  const HullReport raw = hull_of(scene, {}), cleaned = hull_of(scene, {.triangles = 200});
  ASSERT_GT(check_mesh(raw.mesh).genus, 60) << "more than 200 triangles hold";
  ASSERT_TRUE(cleaned.cleanup);
  EXPECT_THAT(cleaned.mesh, IsClosed());
  EXPECT_LE(cleaned.mesh.triangle_count(), 200u);
  EXPECT_EQ(cleaned.cleanup->triangles_before, raw.mesh.triangle_count());
  EXPECT_THAT(cleaned.remarks, Contains(HasSubstr("was taken out of the silhouettes")));
  EXPECT_THAT(cleaned.remarks, testing::Not(Contains(HasSubstr("decimation stopped"))));
  for (std::size_t c = 0; c < scene.rig.cameras.size(); ++c) {
    const Matte now = mesh_mask(scene.rig.cameras[c], cleaned.mesh);
    EXPECT_NEAR(cleaned.cleanup->iou_loss[c],
                iou(mesh_mask(scene.rig.cameras[c], raw.mesh), scene.mattes[c]) - iou(now, scene.mattes[c]),
                1e-9);
    EXPECT_GE(iou(now, plain[c]), 0.93) << "of the body";
  }
}

TEST(MeshCleanup, SmoothsWithinItsPixels) {
  for (const auto& [name, scene] : bodies()) {
    const HullReport raw = hull_of(scene, {});
    for (const double px : {0.25, 0.5}) {
      const HullReport cleaned = hull_of(scene, {.smooth = 10, .largest_move = px, .largest_loss = 0.05});
      ASSERT_TRUE(cleaned.cleanup) << name;
      EXPECT_THAT(cleaned.mesh, IsClosed()) << name;
      EXPECT_EQ(cleaned.mesh.triangles, raw.mesh.triangles) << name << ": only positions change";
      EXPECT_NE(cleaned.mesh.positions, raw.mesh.positions) << name;
      EXPECT_THAT(cleaned.cleanup->vertex_move, Each(Le(px + 0.001))) << name;
      EXPECT_THAT(cleaned.cleanup->silhouette_shift, Each(Le(1.5))) << name << ": pixels are counted whole";
      for (std::size_t v = 0; v < raw.mesh.positions.size(); ++v) {
        for (const RigCamera& camera : scene.rig.cameras) {
          const Vector2d was =
              *project(camera.model, camera.cam_from_world * raw.mesh.positions[v].cast<double>());
          const Vector2d is =
              *project(camera.model, camera.cam_from_world * cleaned.mesh.positions[v].cast<double>());
          ASSERT_LE((is - was).norm(), px + 0.001) << name;
        }
      }
    }
  }
}

/// How far the triangles of a round body's mesh face away from its middle: mean of 1 - cosine over the
/// surface.
double unevenness(const Mesh& mesh) {
  double sum = 0, whole = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const auto at = [&](std::size_t k) -> Vector3d {
      return mesh.positions[mesh.triangles[t + k]].cast<double>();
    };
    const Vector3d area = (at(1) - at(0)).cross(at(2) - at(0));
    sum += area.norm() - area.dot((at(0) + at(1) + at(2)).normalized());
    whole += area.norm();
  }
  return sum / whole;
}

TEST(MeshCleanup, SmoothingMakesARoundBodySmootherAndDoesNotShrinkIt) {
  Scene scene = scene_of(shapes::sphere({0, 0, 0}, 0.5), 24);
  Random random(3);
  for (Matte& matte : scene.mattes) {  // outlines that jitter by about a third of a pixel
    Image alpha = to_image(matte);
    for (std::uint8_t& a : alpha.pixels)
      if (a > 0 && a < 255) a = static_cast<std::uint8_t>(std::clamp(a + 80 * random.normal(), 1.0, 254.0));
    matte = make_matte({}, alpha);
  }
  const HullReport raw = hull_of(scene, {.collapse_slivers = true, .triangles = 1500});
  const HullReport cleaned =
      hull_of(scene, {.collapse_slivers = true, .triangles = 1500, .smooth = 10, .largest_loss = 0.05});
  EXPECT_LT(unevenness(cleaned.mesh), 0.7 * unevenness(raw.mesh));
  EXPECT_NEAR(cleaned.volume / raw.volume, 1, 0.01);
}

TEST(MeshCleanup, HoldsSmoothingBackWhereASilhouetteWouldSuffer) {
  const Scene scene = scene_of(shapes::box({0, 0, 0}, {0.7, 0.5, 0.6}));
  const MeshCleanup far{.smooth = 30, .largest_move = 8, .largest_loss = 1};
  MeshCleanup held = far;
  held.largest_loss = 0.003;
  const HullReport loose = hull_of(scene, far), tight = hull_of(scene, held);
  EXPECT_GT(*std::max_element(loose.cleanup->iou_loss.begin(), loose.cleanup->iou_loss.end()), 0.003)
      << "corners of a box that may move by eight pixels are rounded off";
  EXPECT_EQ(loose.cleanup->smoothed_within, 8);
  EXPECT_LT(tight.cleanup->smoothed_within, 8);
  EXPECT_THAT(tight.cleanup->iou_loss, Each(Le(0.003)));
}

TEST(MeshCleanup, CaresForTheOctreesHullsToo) {
  const Scene scene = scene_of(shapes::torus({0, 0, 0}, 0.4, 0.13), 20);
  const HullReport raw = hull_of(scene, {}, HullMethod::Octree);
  const HullReport cleaned =
      hull_of(scene, {.collapse_slivers = true, .triangles = 800, .smooth = 2}, HullMethod::Octree);
  EXPECT_THAT(cleaned.mesh, IsClosed());
  EXPECT_EQ(check_mesh(cleaned.mesh).genus, 1);
  EXPECT_LE(cleaned.mesh.triangle_count(), 800u);
  EXPECT_LT(cleaned.mesh.triangle_count(), raw.mesh.triangle_count());
}

TEST(MeshCleanup, RemembersWhereEveryTriangleThatIsLeftCameFrom) {
  const Scene scene = scene_of(shapes::sphere({0, 0, 0}, 0.5));
  const HullReport raw = hull_of(scene, {}), cleaned = hull_of(scene, {.collapse_slivers = true});
  ASSERT_EQ(cleaned.sources.size(), cleaned.mesh.triangle_count());
  for (const HullFaceSource& source : cleaned.sources)
    EXPECT_TRUE(std::find(raw.sources.begin(), raw.sources.end(), source) != raw.sources.end());
}

TEST(MeshCleanup, GivesTheSameBytesAtAnyThreadCount) {
  const Scene scene = scene_of(shapes::torus({0, 0, 0}, 0.4, 0.13), 16);
  HullOptions options;
  options.cleanup = {.collapse_slivers = true, .triangles = 1500, .smooth = 4};
  options.threads = 1;
  const Result<HullReport> one = visual_hull(scene.rig, scene.mattes, options);
  options.threads = 3;
  const Result<HullReport> three = visual_hull(scene.rig, scene.mattes, options);
  ASSERT_THAT(one, IsOk());
  ASSERT_THAT(three, IsOk());
  EXPECT_EQ(one->mesh.positions, three->mesh.positions);
  EXPECT_EQ(one->mesh.triangles, three->mesh.triangles);
  EXPECT_EQ(one->cleanup->iou_loss, three->cleanup->iou_loss);
}

TEST(MeshCleanup, RefusesOptionsOutOfRange) {
  const Scene scene = scene_of(shapes::sphere({0, 0, 0}, 0.5), 4);
  const std::pair<MeshCleanup, const char*> wrong[] = {{{.smooth = -1}, "rounds of smoothing"},
                                                       {{.largest_move = -0.5}, "largest move"},
                                                       {{.largest_loss = 2}, "largest loss"},
                                                       {{.triangles = 3}, "closes no surface"}};
  for (const auto& [cleanup, sentence] : wrong) {
    HullOptions options;
    options.cleanup = cleanup;
    EXPECT_THAT(visual_hull(scene.rig, scene.mattes, options),
                FailsWith(ErrorCode::InvalidArgument, sentence));
  }
}

TEST(Sliver, IsATriangleFiftyTimesAsLongAsHigh) {
  EXPECT_FALSE(is_sliver({0, 0, 0}, {1, 0, 0}, {0.5, 0.03, 0}));
  EXPECT_TRUE(is_sliver({0, 0, 0}, {1, 0, 0}, {0.5, 0.01, 0})) << "a cap";
  EXPECT_TRUE(is_sliver({0, 0, 0}, {1, 0, 0}, {1, 0.01, 0})) << "a needle";
  EXPECT_TRUE(is_sliver({0, 0, 0}, {1, 0, 0}, {0.3, 0, 0})) << "no area at all";
}

TEST(MaskDistance, IsThatOfTheFurthestPixelOfEitherMask) {
  const auto mask = [](auto inside) {
    Image image(40, 30, 1);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) *image.at(x, y) = inside(x, y) ? 255 : 0;
    return make_matte({}, image);
  };
  const auto block = [](int x, int y) { return x >= 10 && x < 20 && y >= 10 && y < 20; };
  const Matte plain = mask(block);
  EXPECT_EQ(mask_distance(plain, plain), 0);
  const Matte horn = mask([&](int x, int y) { return block(x, y) || (x == 25 && y == 14); });
  EXPECT_EQ(mask_distance(plain, horn), 6);
  EXPECT_EQ(mask_distance(horn, plain), 6);
  const Matte corner = mask([&](int x, int y) { return block(x, y) || (x == 22 && y == 23); });
  EXPECT_EQ(mask_distance(plain, corner), 5) << "3 right, 4 down";
  const Matte nothing = mask([](int, int) { return false; });
  EXPECT_EQ(mask_distance(nothing, nothing), 0);
  EXPECT_EQ(mask_distance(plain, nothing), 50) << "the diagonal";
}

}  // namespace
}  // namespace floatstage::recon
