#include "recon/octree/octree_carve.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/support/analytic_shapes.h"

namespace floatstage::recon {
namespace {

const Lens kLenses[] = {Lens{}, Lens{BrownConrady{-0.25, 0.08, 2e-3, -1e-3, 0.01}},
                        Lens{BrownConrady{0.2, 0.05, 0, 0, 0}}, Lens{KannalaBrandt{0.03, -0.01, 0.002, 0}}};

// A noisy silhouette: blobs and holes at every scale.
Matte speckled_matte(const RigCamera& camera, Random& random) {
  Image alpha(camera.model.width, camera.model.height, 1);
  for (int blob = 0; blob < 40; ++blob) {
    const double x = random.uniform(0, alpha.width), y = random.uniform(0, alpha.height);
    const double radius = random.uniform(0.5, 25);
    const std::uint8_t value =
        random.uniform() < 0.7 ? static_cast<std::uint8_t>(random.uniform(100, 256)) : 0;
    for (int v = 0; v < alpha.height; ++v)
      for (int u = 0; u < alpha.width; ++u)
        if (std::hypot(u + 0.5 - x, v + 0.5 - y) < radius) *alpha.at(u, v) = value;
  }
  return make_matte({}, alpha);
}

std::vector<OctreeView> speckled_views(const Rig& rig, Random& random) {
  std::vector<OctreeView> views;
  for (const RigCamera& camera : rig.cameras) views.emplace_back(camera, speckled_matte(camera, random));
  return views;
}

Rig close_ring(int cameras, const Lens& lens) {
  return shapes::ring_rig(
      {.cameras = cameras, .distance = 1.5, .width = 80, .height = 60, .focal = 60, .lens = lens});
}

bool agree(BoxVerdict box, PointVerdict point) {
  switch (box) {
    case BoxVerdict::Unseen:
      return point == PointVerdict::Unseen;
    case BoxVerdict::Background:
      return point == PointVerdict::Background;
    case BoxVerdict::Subject:
      return point == PointVerdict::Subject;
    case BoxVerdict::NotBackground:
      return point != PointVerdict::Background;
    case BoxVerdict::Mixed:
      return true;
  }
  return false;
}

class CarvedThroughEveryLens : public testing::TestWithParam<Lens> {};

TEST_P(CarvedThroughEveryLens, EqualsAskingEveryPoint) {
  Random random(11);
  for (int round = 0; round < 6; ++round) {
    const std::vector<OctreeView> views = speckled_views(close_ring(3, GetParam()), random);
    // Large enough to reach outside the images and behind the cameras.
    const Eigen::AlignedBox3d box(Eigen::Vector3d(-1.9, -1.2, -0.7),
                                  Eigen::Vector3d(1.2, 1.8, random.uniform(0.5, 2)));
    const CarvedGrid grid = carve(views, box, 50, 1);
    int inside = 0;
    for (int z = 0; z < grid.points().z(); ++z) {
      for (int y = 0; y < grid.points().y(); ++y) {
        for (int x = 0; x < grid.points().x(); ++x) {
          const Eigen::Vector3d p = grid.position(x, y, z);
          ASSERT_EQ(grid.inside(x, y, z), box.contains(p) && in_hull(views, p)) << x << " " << y << " " << z;
          inside += grid.inside(x, y, z);
        }
      }
    }
    EXPECT_GT(inside, 100) << "a set-up that carves everything shows nothing";
  }
}

TEST_P(CarvedThroughEveryLens, JudgesBoxesAsItJudgesTheirPoints) {
  Random random(5);
  const std::vector<OctreeView> views = speckled_views(close_ring(4, GetParam()), random);
  int decided = 0;
  for (std::size_t i = 0; i < 20000; ++i) {
    const Eigen::Vector3d corner(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-2, 2));
    const double size = std::pow(10.0, random.uniform(-3, 0));
    const Eigen::Vector3d sides(random.uniform(), random.uniform(), random.uniform());
    const Eigen::AlignedBox3d box(corner, corner + size * sides);
    const OctreeView& view = views[i % views.size()];
    const BoxVerdict verdict = view.over(box);
    decided += verdict != BoxVerdict::Mixed && verdict != BoxVerdict::Unseen;
    for (int k = 0; k < 10; ++k) {
      const Eigen::Vector3d t(random.uniform(), random.uniform(), random.uniform());
      const PointVerdict at = view.at(box.min() + t.cwiseProduct(box.sizes()));
      ASSERT_TRUE(agree(verdict, at)) << static_cast<int>(verdict) << " but " << static_cast<int>(at);
    }
  }
  EXPECT_GT(decided, 500);
}

TEST_P(CarvedThroughEveryLens, ProjectsAsCoreDoes) {
  // A matte whose left half is subject: the verdict changes where project() crosses the middle column.
  const RigCamera camera = shapes::ring_rig({.cameras = 1, .lens = GetParam()}).cameras[0];
  Image half(camera.model.width, camera.model.height, 1);
  for (int y = 0; y < half.height; ++y) std::fill_n(half.at(0, y), half.width / 2, 255);
  const OctreeView view(camera, make_matte({}, half));
  Random random(3);
  int seen = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d p(random.uniform(-2, 4), random.uniform(-3, 3), random.uniform(-2, 3));
    const auto pixel = project(camera.model, camera.cam_from_world * p);
    PointVerdict expected = PointVerdict::Unseen;
    if (pixel && inside(camera.model, *pixel))
      expected = pixel->x() <= half.width / 2 ? PointVerdict::Subject : PointVerdict::Background;
    EXPECT_EQ(view.at(p), expected) << p.transpose();
    seen += expected != PointVerdict::Unseen;
  }
  EXPECT_GT(seen, 300);
}

INSTANTIATE_TEST_SUITE_P(Lenses, CarvedThroughEveryLens, testing::ValuesIn(kLenses));

TEST(Carve, GivesTheSameBitsAtAnyThreadCount) {
  Random random(2);
  const std::vector<OctreeView> views = speckled_views(shapes::ring_rig({.cameras = 5}), random);
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 0.7));
  const CarvedGrid one = carve(views, box, 90, 1), three = carve(views, box, 90, 3);
  ASSERT_EQ(one.points(), three.points());
  for (int z = 0; z < one.points().z(); ++z)
    for (int y = 0; y < one.points().y(); ++y)
      for (std::size_t w = 0; w < one.words_per_row(); ++w) ASSERT_EQ(one.row(y, z)[w], three.row(y, z)[w]);
}

TEST(ShrinkToHull, KeepsEveryPointOfTheHullAndLittleElse) {
  const Rig rig = shapes::sphere_rig({.cameras = 12});
  std::vector<OctreeView> views;
  for (const RigCamera& c : rig.cameras)
    views.emplace_back(c, shapes::render_matte(c, shapes::sphere({0.2, 0, -0.1}, 0.3)));
  const Eigen::AlignedBox3d box =
      shrink_to_hull(views, {Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1)});
  const Eigen::AlignedBox3d tight(Eigen::Vector3d(-0.1, -0.3, -0.4), Eigen::Vector3d(0.5, 0.3, 0.2));
  EXPECT_TRUE(box.contains(tight));
  EXPECT_LT(box.sizes().maxCoeff(), 0.75);
}

TEST(ShrinkToHull, IsEmptyWhenEverythingIsCarved) {
  const Rig rig = shapes::ring_rig({.cameras = 2});
  std::vector<OctreeView> views;
  for (const RigCamera& c : rig.cameras) views.emplace_back(c, shapes::uniform_matte(c, 0));
  EXPECT_TRUE(
      shrink_to_hull(views, {Eigen::Vector3d(-0.1, -0.1, -0.1), Eigen::Vector3d(0.1, 0.1, 0.1)}).isEmpty());
}

}  // namespace
}  // namespace floatstage::recon
