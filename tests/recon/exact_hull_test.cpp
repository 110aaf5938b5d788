#include "recon/exact/exact_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/recon/cone_oracle.h"
#include "tests/recon/cone_views.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSphere = 4.0 / 3 * std::numbers::pi;

struct Computed {
  ExactOutcome outcome;
  HullPolygons polygons;
  MeshCheck check;
};

Computed hull_of(std::vector<ConeView> views, const ExactOptions& options = {}) {
  ExactHull engine;
  Computed out;
  out.outcome = engine.compute(views, options);
  out.polygons = engine.polygons();
  out.check = check_mesh(to_mesh(out.polygons));
  return out;
}

ExactOptions starting_at(ExactLevel level) {
  ExactOptions options;
  options.start = level;
  return options;
}

MATCHER(IsSound, "is closed, manifold, oriented and outward") {
  *result_listener << "level " << static_cast<int>(arg.outcome.level) << ", " << arg.outcome.attempts
                   << " attempts, unmatched " << arg.polygons.unmatched << ", irregular "
                   << arg.polygons.irregular << "; " << arg.check.summary();
  return arg.outcome.closed && arg.check.watertight && arg.check.manifold && arg.check.oriented &&
         arg.check.outward;
}

std::vector<ConeView> spheres(int cameras, double radius, int sides) {
  std::vector<ConeView> views;
  int k = 0;
  for (const Vector3d& center : cones::around(cameras, 3)) {
    views.push_back(cones::of_sphere(center, radius, sides, 0.1 * k++));
  }
  return views;
}

TEST(ExactHull, HasTwiceItsFacesLessFourVertices) {
  const Computed hull = hull_of(spheres(8, 0.5, 100));
  ASSERT_THAT(hull, IsSound());
  EXPECT_EQ(hull.outcome.level, ExactLevel::Doubles);
  EXPECT_EQ(hull.check.genus, 0);
  const std::size_t polygons = hull.polygons.polygon_start.size() - 1;
  EXPECT_EQ(hull.polygons.positions.size(), 2 * polygons - 4);
  EXPECT_EQ(hull.polygons.triangles.size() / 3, 4 * polygons - 12);
}

TEST(ExactHull, OfCutCubesEqualsTheCube) {
  // Three cameras that each see two faces edge-on would be degenerate; these see the cube from its diagonals.
  std::vector<ConeView> views;
  for (const Vector3d& center : cones::around(30, 40))
    views.push_back(cones::of_convex(center, cones::cube_corners(0.5)));
  const Computed hull = hull_of(views);
  ASSERT_THAT(hull, IsSound());
  EXPECT_GT(hull.polygons.volume, 1 - 1e-6);
  EXPECT_LT(hull.polygons.volume, 1.2);
}

TEST(ExactHull, HasTheVolumeThatClippingConvexConesGives) {
  Random random(7);
  for (int round = 0; round < 10; ++round) {
    std::vector<ConeView> views;
    for (Vector3d center : cones::around(5, 3)) {
      center += 0.2 * Vector3d(random.normal(), random.normal(), random.normal());
      views.push_back(cones::of_sphere(center, random.uniform(0.4, 0.6), 9, random.uniform()));
    }
    const double oracle = volume_by_clipping(views, 5);
    const Computed hull = hull_of(views);
    ASSERT_THAT(hull, IsSound());
    EXPECT_NEAR(hull.polygons.volume / oracle, 1, 1e-9);
    EXPECT_NEAR(hull.check.volume / oracle, 1, 1e-5) << "the triangles, in floats";
  }
}

TEST(ExactHull, HasTheVolumeThatClippingStarsWithHolesGives) {
  Random random(11);
  for (int round = 0; round < 10; ++round) {
    const auto views =
        cones::random_stars(random, {{3, 0.1, 0.2}, {-0.3, 2.8, 0.5}, {0.4, -0.2, 3.1}}, 4, true);
    const double oracle = volume_by_clipping(views, 3);
    for (const ExactLevel level : {ExactLevel::Doubles, ExactLevel::Integers}) {
      const Computed hull = hull_of(views, starting_at(level));
      ASSERT_THAT(hull, IsSound()) << round;
      EXPECT_NEAR(hull.polygons.volume / oracle, 1, 1e-6);
    }
  }
}

TEST(ExactHull, OfFourOutOfFiveVotesHasTheVolumeOfInclusionAndExclusion) {
  Random random(3);
  for (int round = 0; round < 4; ++round) {
    std::vector<ConeView> views;
    for (Vector3d center : cones::around(5, 3)) {
      center += 0.3 * Vector3d(random.normal(), random.normal(), random.normal());
      views.push_back(cones::of_sphere(center, random.uniform(0.3, 0.6), 7, random.uniform()));
    }
    for (const int votes : {5, 4, 3}) {
      ExactOptions options;
      options.votes = votes;
      const Computed hull = hull_of(views, options);
      ASSERT_THAT(hull, IsSound()) << votes << " votes, round " << round;
      EXPECT_NEAR(hull.polygons.volume / volume_by_clipping(views, votes), 1, 1e-9) << votes << " votes";
    }
  }
}

TEST(ExactHull, ConvergesToTheSphereAsCamerasAreAdded) {
  double last = 1e9;
  const auto centers = cones::around(32, 4);
  for (const int cameras : {4, 8, 16, 32}) {  // nested: every (32 / n)th camera
    std::vector<ConeView> views;
    for (int k = 0; k < cameras; ++k) {
      views.push_back(cones::of_sphere(centers[static_cast<std::size_t>(k * 32 / cameras)], 0.6, 180));
    }
    const Computed hull = hull_of(views);
    ASSERT_THAT(hull, IsSound());
    EXPECT_LT(hull.polygons.volume, last);
    last = hull.polygons.volume;
  }
  EXPECT_GT(last / (kSphere * 0.216), 0.999);
}

TEST(ExactHull, IsClosedWhereDoublesMustFail) {
  // Coplanar rings around polyhedra: all rays of one corner meet in it, epipolar planes contain edges and
  // centres.
  int escalated = 0;
  for (const int cameras : {3, 4, 5, 6, 8, 12, 16}) {
    for (const bool cube : {true, false}) {
      for (const double z : {0.0, 1.0}) {
        std::vector<ConeView> views;
        const auto corners = cube ? cones::cube_corners(0.5) : cones::octahedron_corners(0.7);
        for (const Vector3d& center : cones::ring(cameras, 3, z))
          views.push_back(cones::of_convex(center, corners));
        views.push_back(cones::of_convex({0, 0, 3}, corners));
        const Computed hull = hull_of(views);
        ASSERT_THAT(hull, IsSound()) << cameras << (cube ? " cameras, cube, z " : " cameras, octahedron, z ")
                                     << z;
        escalated += hull.outcome.level != ExactLevel::Doubles;
        const double body = cube ? 1 : 4.0 / 3 * std::pow(0.7, 3);
        EXPECT_GT(hull.polygons.volume, body * (1 - 1e-5));
      }
    }
  }
  EXPECT_GT(escalated, 0) << "these rigs are meant to be degenerate";
}

TEST(ExactHull, IsExactlyTheCubeThatACoplanarRingSeesWithTheIntegersToo) {
  std::vector<ConeView> views;
  for (const Vector3d& center : cones::ring(4, 3, 0))
    views.push_back(cones::of_convex(center, cones::cube_corners(0.5)));
  const Computed any = hull_of(views), exact = hull_of(views, starting_at(ExactLevel::Integers));
  ASSERT_THAT(exact, IsSound());
  ASSERT_THAT(any, IsSound());
  EXPECT_NEAR(any.polygons.volume / exact.polygons.volume, 1, 1e-4);
}

TEST(ExactHull, SurvivesAThousandPerturbationsOfADegenerateRig) {
  Random random(5);
  for (int round = 0; round < 1000; ++round) {
    const double noise = std::pow(10, random.uniform(-17, -2));
    std::vector<ConeView> views;
    for (const Vector3d& center : cones::ring(5, 3, round % 2)) {
      views.push_back(cones::of_convex(center, cones::cube_corners(0.5)));
      for (Vector3d& ray : views.back().rays)
        ray += noise * Vector3d(random.normal(), random.normal(), random.normal());
    }
    const Computed hull = hull_of(views);
    ASSERT_THAT(hull, IsSound()) << "round " << round << ", noise " << noise;
  }
}

TEST(ExactHull, MovesTheEndsOfEdgesWithoutLengthApart) {
  const std::vector<ConeView> views = spheres(5, 0.6, 12);
  const Computed clean = hull_of(views);
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::vector<ConeView> repeated = views;
    std::vector<Vector3d> rays = views[v].rays;
    rays.insert(rays.begin() + 4, rays[4]);
    repeated[v].clear();
    repeated[v].center = views[v].center;
    repeated[v].add_loop(rays);
    const Computed hull = hull_of(repeated);
    EXPECT_THAT(hull, IsSound());
    EXPECT_NEAR(hull.polygons.volume / clean.polygons.volume, 1, 1e-5);
  }
}

TEST(ExactHull, TakesCamerasThatSeeEachOther) {
  // Opposite cameras on the axis: each one's image of the other lies inside its silhouette.
  std::vector<ConeView> views;
  for (const Vector3d& center :
       {Vector3d(3, 0, 0.05), Vector3d(-3, 0.01, 0), Vector3d(0.1, 3, 0.2), Vector3d(0, -3, 0.02)}) {
    views.push_back(cones::of_sphere(center, 0.5, 14, center.x()));
  }
  const Computed hull = hull_of(views);
  ASSERT_THAT(hull, IsSound());
  EXPECT_NEAR(hull.polygons.volume / volume_by_clipping(views, 4), 1, 1e-9);
}

TEST(ExactHull, ReachesACameraThatStandsInsideTheOthersSilhouettes) {
  std::vector<ConeView> views;
  for (const Vector3d& center : {Vector3d(3, 0, 0), Vector3d(0, 3, 0.1), Vector3d(0.1, 0.2, 3)}) {
    views.push_back(cones::of_sphere(center, 0.8, 20));
  }
  ConeView close = cones::at({0.2, 0.1, 0.05});
  cones::add_polygon(close, {{0.1, 0}, {0, 0.1}, {-0.1, 0}, {0, -0.1}});
  views.push_back(close);
  const Computed hull = hull_of(views);
  ASSERT_THAT(hull, IsSound());
  EXPECT_NEAR(hull.polygons.volume / volume_by_clipping(views, 4), 1, 1e-9);
}

TEST(ExactHull, HasOneShellForEachObjectAndAGenusForEachHole) {
  std::vector<ConeView> views;
  for (const Vector3d& center : {Vector3d(3, 0.2, 0.3), Vector3d(-0.4, 3, 0.2), Vector3d(0.3, -0.1, 3)}) {
    ConeView view = cones::at(center);
    cones::add_polygon(view, {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}});
    cones::add_polygon(view, {{-0.2, -0.2}, {-0.2, 0.2}, {0.2, 0.2}, {0.2, -0.2}});
    views.push_back(view);
  }
  const Computed frame = hull_of(views);
  ASSERT_THAT(frame, IsSound());
  EXPECT_EQ(frame.check.shells, 1);
  EXPECT_EQ(frame.check.genus, 5) << "a cube with three tunnels that meet";

  views.clear();
  for (const Vector3d& center : {Vector3d(3, 0.2, 0.3), Vector3d(-0.4, 3, 0.2)}) {
    ConeView view = cones::at(center);
    for (const double x : {-0.6, 0.4}) {
      cones::add_polygon(view, {{x, -0.1}, {x + 0.2, -0.1}, {x + 0.2, 0.1}, {x, 0.1}});
    }
    views.push_back(view);
  }
  EXPECT_EQ(hull_of(views).check.shells, 4) << "two real bars and two ghosts";
}

TEST(ExactHull, SaysSoWhenTheViewsDoNotBoundIt) {
  std::vector<ConeView> views = {cones::of_sphere({3, 0, 0}, 0.5, 8), cones::of_sphere({3, 0.5, 0}, 0.5, 8)};
  EXPECT_TRUE(hull_of(views).outcome.unbounded);
  for (ConeView& view : volume_views({Vector3d(-1, -1, -1), Vector3d(1, 1, 1)})) views.push_back(view);
  const Computed bounded = hull_of(views);
  ASSERT_THAT(bounded, IsSound());
  EXPECT_LT(bounded.polygons.volume, 8);
}

TEST(ExactHull, GivesTheSameBytesAtAnyThreadCount) {
  Random random(2);
  const auto views = cones::random_stars(random, cones::around(9, 3), 12, true);
  const Computed one = hull_of(views);
  ASSERT_THAT(one, IsSound());
  for (const int threads : {2, 3, 7}) {
    ExactOptions options;
    options.threads = threads;
    const Computed more = hull_of(views, options);
    EXPECT_EQ(one.polygons.positions, more.polygons.positions);
    EXPECT_EQ(one.polygons.triangles, more.polygons.triangles);
    EXPECT_EQ(one.polygons.volume, more.polygons.volume);
  }
}

TEST(ExactHull, KnowsWhichContourEdgeEveryTriangleCameFrom) {
  const std::vector<ConeView> views = spheres(6, 0.5, 40);
  const Computed hull = hull_of(views);
  ASSERT_EQ(hull.polygons.triangle_face.size() * 3, hull.polygons.triangles.size());
  for (std::size_t t = 0; t < hull.polygons.triangle_face.size(); ++t) {
    const HullPolygons::Face& face =
        hull.polygons.faces[static_cast<std::size_t>(hull.polygons.triangle_face[t])];
    const ConeView& view = views[static_cast<std::size_t>(face.view)];
    const Vector3d normal = view.rays[face.edge].cross(view.rays[view.next[face.edge]]).normalized();
    for (int k = 0; k < 3; ++k) {
      const Vector3d corner = hull.polygons.positions[hull.polygons.triangles[3 * t + k]];
      EXPECT_NEAR(normal.dot(corner - view.center), 0, 1e-9);
    }
  }
}

/// What a hull is, whatever order its parts are numbered in.
std::vector<std::array<double, 3>> sorted_positions(const HullPolygons& hull) {
  std::vector<std::array<double, 3>> out;
  for (const Vector3d& p : hull.positions) out.push_back({p.x(), p.y(), p.z()});
  std::sort(out.begin(), out.end());
  return out;
}

TEST(ExactHull, IsTheSameWithoutLeavingAnythingOut) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Random random(seed + 50);
    const int cameras = 4 + static_cast<int>(seed % 6);
    const auto views = cones::random_stars(random, cones::around(cameras, 3), 10, seed % 2 == 0);
    for (const int votes : {0, cameras - 1, cameras - 2}) {
      ExactOptions options;
      options.votes = std::max(votes, 0);
      const Computed culled = hull_of(views, options);
      options.cull = false;
      const Computed reference = hull_of(views, options);
      ASSERT_EQ(culled.outcome.closed, reference.outcome.closed) << "seed " << seed << ", votes " << votes;
      ASSERT_EQ(culled.outcome.unbounded, reference.outcome.unbounded)
          << "seed " << seed << ", votes " << votes;
      EXPECT_EQ(culled.outcome.level, reference.outcome.level);
      EXPECT_EQ(sorted_positions(culled.polygons), sorted_positions(reference.polygons)) << "seed " << seed;
      EXPECT_EQ(culled.polygons.polygon_start.size(), reference.polygons.polygon_start.size());
      EXPECT_NEAR(culled.polygons.volume, reference.polygons.volume, 1e-12);
    }
  }
}

TEST(ExactHull, OfRandomStarsIsSoundForAnyNumberOfVotes) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Random random(seed);
    const int cameras = 4 + static_cast<int>(seed % 5);
    const auto views = cones::random_stars(random, cones::around(cameras, 3), 8, seed % 2 == 0);
    for (int votes = std::max(3, cameras - 2); votes <= cameras; ++votes) {
      ExactOptions options;
      options.votes = votes;
      const Computed hull = hull_of(views, options);
      if (hull.outcome.unbounded) continue;  // too few votes can reach to infinity
      EXPECT_THAT(hull, IsSound()) << "seed " << seed << ", " << votes << " of " << cameras;
    }
  }
}

}  // namespace
}  // namespace floatstage::recon
