// The exact hull against general constructive solid geometry with exact numbers.

#include <gtest/gtest.h>

#include "tests/recon/cone_oracle.h"
#include "tests/recon/cone_views.h"
#include "tests/recon/csg_oracle.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

void expect_volume_of_csg(std::vector<ConeView> views, const char* what) {
  const double oracle = volume_by_csg(views, 6);
  ASSERT_GT(oracle, 0) << what << ": CGAL found no manifold";
  for (const ExactLevel level : {ExactLevel::Doubles, ExactLevel::Integers}) {
    std::vector<ConeView> moved = views;
    ExactHull engine;
    ExactOptions options;
    options.start = level;
    ASSERT_TRUE(engine.compute(moved, options).closed) << what;
    EXPECT_NEAR(engine.polygons().volume / oracle, 1, 1e-6) << what << ", level " << static_cast<int>(level);
  }
}

TEST(ConstructiveSolidGeometry, AgreesWithClippingOnTheSameCones) {
  Random random(4);
  const auto views =
      cones::random_stars(random, {{3, 0.1, 0.2}, {-0.3, 2.8, 0.5}, {0.4, -0.2, 3.1}}, 4, true);
  EXPECT_NEAR(volume_by_csg(views, 6) / volume_by_clipping(views, 3), 1, 1e-9);
}

TEST(ConstructiveSolidGeometry, GivesTheVolumeOfHullsOfSpheres) {
  Random random(6);
  for (const int cameras : {3, 6, 10}) {
    std::vector<ConeView> views;
    for (Vector3d center : cones::around(cameras, 3)) {
      center += 0.1 * Vector3d(random.normal(), random.normal(), random.normal());
      views.push_back(cones::of_sphere(center, random.uniform(0.4, 0.6), 24, random.uniform()));
    }
    expect_volume_of_csg(views, "spheres");
  }
}

TEST(ConstructiveSolidGeometry, GivesTheVolumeOfHullsOfStarsWithHoles) {
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    Random random(seed);
    expect_volume_of_csg(cones::random_stars(random, cones::around(4 + static_cast<int>(seed), 3), 5, true),
                         "stars");
  }
}

TEST(ConstructiveSolidGeometry, GivesTheVolumeOfHullsOfACoplanarRingAroundACube) {
  std::vector<ConeView> views;
  for (const Vector3d& center : cones::ring(6, 3, 0))
    views.push_back(cones::of_convex(center, cones::cube_corners(0.5)));
  const double oracle = volume_by_csg(views, 6);
  ExactHull engine;
  ASSERT_TRUE(engine.compute(views, {}).closed);
  EXPECT_NEAR(engine.polygons().volume / oracle, 1, 1e-6) << "in spite of the jitter";
}

}  // namespace
}  // namespace floatstage::recon
