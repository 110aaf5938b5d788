#include "recon/visual_hull.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "recon/mesh/mesh_check.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kSphere = 4.0 / 3 * std::numbers::pi;

/// What both methods promise. The resolution is the octree's; the exact method takes no notice of it.
class VisualHull : public testing::TestWithParam<HullMethod> {
 protected:
  static HullOptions at_resolution(int resolution) {
    HullOptions options;
    options.method = GetParam();
    options.contour_tolerance = 0.1;  // these bodies span few pixels
    options.resolution = resolution;
    return options;
  }
  static HullOptions within(const Eigen::AlignedBox3d& volume, int resolution) {
    HullOptions options = at_resolution(resolution);
    options.volume = volume;
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(Methods, VisualHull, testing::Values(HullMethod::Exact, HullMethod::Octree),
                         [](const auto& method) {
                           return method.param == HullMethod::Exact ? "Exact" : "Octree";
                         });

HullOptions octree_at(int resolution) {
  HullOptions options;
  options.method = HullMethod::Octree;
  options.resolution = resolution;
  return options;
}

HullReport hull_of(const Rig& rig, const std::vector<Matte>& mattes, const HullOptions& options) {
  Result<HullReport> hull = visual_hull(rig, mattes, options);
  EXPECT_THAT(hull, IsOk());
  return hull ? std::move(*hull) : HullReport{};
}

MATCHER(IsGood, "is closed, manifold, outward and crosses itself nowhere") {
  const MeshCheck check = check_mesh(arg);
  *result_listener << check.summary();
  return check.good() && check.degenerate == 0;
}

// An exact hull has the triangles that its silhouettes ask for: also slivers, which rounding to floats may
// flatten.
MATCHER(IsClosed, "is closed, manifold and outward") {
  const MeshCheck check = check_mesh(arg);
  *result_listener << check.summary();
  return check.watertight && check.manifold && check.oriented && check.outward;
}

testing::Matcher<const Mesh&> is_sound(HullMethod method) {
  if (method == HullMethod::Exact) return IsClosed();
  return IsGood();
}

TEST_P(VisualHull, OfASphereIsALittleLargerThanTheSphere) {
  const Rig rig = shapes::sphere_rig({.cameras = 24, .width = 320, .height = 240, .focal = 400});
  const HullReport hull =
      hull_of(rig, shapes::render_mattes(rig, shapes::sphere({0.1, 0, 0}, 0.5)), at_resolution(96));
  EXPECT_THAT(hull.mesh, is_sound(GetParam()));
  EXPECT_EQ(check_mesh(hull.mesh).genus, 0);
  EXPECT_GT(hull.volume, kSphere * 0.125);
  EXPECT_LT(hull.volume, kSphere * 0.125 * 1.06);
  for (double iou : hull.silhouette_iou) EXPECT_GT(iou, 0.99);
  EXPECT_THAT(hull.remarks, IsEmpty());
}

TEST_P(VisualHull, ComesNearerToTheSphereWithEveryDoublingOfTheCameras) {
  double last = 1e9;
  for (const int cameras : {4, 8, 16, 32}) {
    const Rig rig = shapes::sphere_rig({.cameras = cameras, .focal = 250});
    const auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.5));
    const double volume = hull_of(rig, mattes, at_resolution(80)).volume;
    EXPECT_LT(volume, last) << cameras << " cameras";
    last = volume;
  }
  EXPECT_NEAR(last / (kSphere * 0.125), 1, 0.02);
}

TEST(OctreeHull, ConvergesWithTheResolution) {
  const Rig rig = shapes::sphere_rig({.cameras = 12, .focal = 250});
  const auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.5));
  const double finest = hull_of(rig, mattes, octree_at(200)).volume;
  const double coarse = std::abs(hull_of(rig, mattes, octree_at(25)).volume - finest);
  const double fine = std::abs(hull_of(rig, mattes, octree_at(100)).volume - finest);
  EXPECT_LT(fine, coarse / 3);
  EXPECT_LT(fine, 0.003 * finest);
}

TEST_P(VisualHull, ContainsTheBodyItCameFrom) {
  const Rig rig = shapes::ring_rig({.cameras = 10, .focal = 200});
  const auto mattes = shapes::render_mattes(rig, shapes::box({0, 0, 0}, {0.6, 0.4, 0.5}));
  const HullReport hull = hull_of(rig, mattes, at_resolution(64));
  EXPECT_THAT(hull.mesh, is_sound(GetParam()));
  EXPECT_GT(hull.volume, 0.6 * 0.4 * 0.5 * 0.99);
  const Eigen::AlignedBox3f bounds = bounding_box(hull.mesh);
  const Vector3d half(0.3, 0.2, 0.25);
  const double slack = std::max(hull.voxel, 0.01);  // a pixel is 15 mm there
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(bounds.min()[axis], -half[axis] + slack);
    EXPECT_GT(bounds.max()[axis], half[axis] - slack);
  }
}

TEST_P(VisualHull, OfATorusHasItsHole) {
  const Rig rig = shapes::sphere_rig({.cameras = 20, .focal = 200});
  const HullReport hull =
      hull_of(rig, shapes::render_mattes(rig, shapes::torus({0, 0, 0}, 0.4, 0.12)), at_resolution(80));
  EXPECT_THAT(hull.mesh, is_sound(GetParam()));
  EXPECT_EQ(check_mesh(hull.mesh).shells, 1);
  EXPECT_EQ(check_mesh(hull.mesh).genus, 1);
}

TEST_P(VisualHull, OfTwoBodiesHasTwoShells) {
  const Rig rig = shapes::sphere_rig({.cameras = 16, .focal = 180});
  const auto shape =
      shapes::both(shapes::sphere({-0.5, 0, 0}, 0.25), shapes::box({0.5, 0.1, 0}, {0.3, 0.3, 0.3}));
  const HullReport hull = hull_of(rig, shapes::render_mattes(rig, shape), at_resolution(96));
  EXPECT_THAT(hull.mesh, is_sound(GetParam()));
  EXPECT_EQ(check_mesh(hull.mesh).shells, 2);
}

TEST_P(VisualHull, IsNotCarvedByACameraWithoutAMatte) {
  const Rig rig = shapes::ring_rig({.cameras = 6});
  auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.5));
  Rig without = rig;
  without.cameras.erase(without.cameras.begin() + 2);
  auto fewer = mattes;
  fewer.erase(fewer.begin() + 2);
  mattes[2] = {};
  const HullReport with_empty = hull_of(rig, mattes, at_resolution(48)),
                   reference = hull_of(without, fewer, at_resolution(48));
  ASSERT_FALSE(reference.mesh.empty());
  EXPECT_THAT(with_empty.mesh, is_sound(GetParam()));
  EXPECT_NEAR(with_empty.volume, reference.volume, 1e-3 * reference.volume);
  EXPECT_EQ(check_mesh(with_empty.mesh).genus, check_mesh(reference.mesh).genus);
  EXPECT_TRUE(std::isnan(with_empty.silhouette_iou[2]));
}

TEST_P(VisualHull, IsEmptyAndSaysWhyWhenACameraSeesOnlyBackground) {
  const Rig rig = shapes::ring_rig({.cameras = 6});
  auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.4));
  mattes[3] = shapes::uniform_matte(rig.cameras[3], 0);
  const HullReport hull = hull_of(rig, mattes, at_resolution(48));
  EXPECT_TRUE(hull.mesh.empty());
  EXPECT_EQ(hull.volume, 0);
  EXPECT_THAT(hull.remarks, Contains(HasSubstr("camera 'c3' sees only background")));
  EXPECT_THAT(hull.remarks, Contains(HasSubstr("hull is empty")));
  EXPECT_EQ(hull.silhouette_iou[3], 1) << "nothing was to be seen and nothing is";
  EXPECT_EQ(hull.silhouette_iou[0], 0);
}

TEST_P(VisualHull, StaysWatertightWhenACameraSeesOnlyBackgroundBesideTheSubject) {
  Rig rig = shapes::ring_rig({.cameras = 6});
  auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.4));
  rig.cameras[3].model.cx = 0;  // its image begins in the middle of the sphere: half of it is carved
  mattes[3] = shapes::uniform_matte(rig.cameras[3], 0);
  const HullReport hull = hull_of(rig, mattes, at_resolution(48));
  EXPECT_FALSE(hull.mesh.empty());
  EXPECT_THAT(hull.mesh, is_sound(GetParam()));
}

TEST_P(VisualHull, IsNotCarvedByWhatLiesOutsideAnImage) {
  Rig rig = shapes::ring_rig({.cameras = 6});
  const auto shape = shapes::sphere({0, 0, 0}, 0.5);
  const HullOptions options = within({Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 64);
  const double whole = hull_of(rig, shapes::render_mattes(rig, shape), options).volume;
  rig.cameras[1].model.cx -= 70;  // the subject is cut by the left border
  auto mattes = shapes::render_mattes(rig, shape);
  const HullReport cut = hull_of(rig, mattes, options);
  EXPECT_THAT(cut.mesh, is_sound(GetParam()));
  EXPECT_GE(cut.volume, whole * 0.999);
  mattes[1] = {};
  EXPECT_LT(cut.volume, hull_of(rig, mattes, options).volume) << "what it does see still carves";
}

TEST_P(VisualHull, StaysWholeWhileThePerformerWalksOutOfOneImage) {
  Rig rig = shapes::ring_rig({.cameras = 6});
  const auto shape =
      shapes::both(shapes::sphere({0, 0, 0.25}, 0.2), shapes::box({0, 0, -0.1}, {0.3, 0.4, 0.5}));
  for (const HullOptions& options :
       {within({Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 48), at_resolution(48)}) {
    rig.cameras[4].model.cx = 80;
    const double whole = hull_of(rig, shapes::render_mattes(rig, shape), options).volume;
    for (const double cx : {40.0, 20.0, 0.0, -20.0, -40.0, -400.0}) {
      rig.cameras[4].model.cx = cx;
      const HullReport hull = hull_of(rig, shapes::render_mattes(rig, shape), options);
      EXPECT_THAT(hull.mesh, is_sound(GetParam())) << "cx " << cx;
      EXPECT_GE(hull.volume, 0.998 * whole) << "cx " << cx << ": what is out of the image is not carved";
      EXPECT_EQ(hull.voxel > 0, GetParam() == HullMethod::Octree) << "cx " << cx;
    }
  }
}

TEST_P(VisualHull, IsClosedByTheSearchedVolume) {
  const Rig rig = shapes::ring_rig({.cameras = 8});
  const auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.5));
  HullOptions options = within({Vector3d(-1, -1, -1), Vector3d(0.1, 1, 1)}, 60);
  options.smoothing = 0;
  const HullReport hull = hull_of(rig, mattes, options);
  EXPECT_THAT(hull.mesh, is_sound(GetParam()));
  EXPECT_NEAR(bounding_box(hull.mesh).max().x(), 0.1, 1e-4) << "the box's own face caps it";
}

TEST_P(VisualHull, FillsAGivenVolumeThatEveryCameraSeesAsSubject) {
  const Rig rig = shapes::ring_rig({.cameras = 4});
  std::vector<Matte> mattes;
  for (const RigCamera& c : rig.cameras) mattes.push_back(shapes::uniform_matte(c, 255));
  const HullReport hull =
      hull_of(rig, mattes, within({Vector3d(-0.2, -0.3, -0.1), Vector3d(0.2, 0.3, 0.1)}, 40));
  EXPECT_THAT(hull.mesh, is_sound(GetParam()));
  EXPECT_NEAR(hull.volume, 0.4 * 0.6 * 0.2, 0.03 * 0.048);
}

TEST_P(VisualHull, HoldsNothingThatNoCameraSees) {
  const Rig rig = shapes::ring_rig({.cameras = 8});
  const auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.3));
  // A hall around the ring: its corners are in no image.
  const HullReport hull =
      hull_of(rig, mattes, within({Vector3d(-2.5, -2.5, -2.5), Vector3d(2.5, 2.5, 2.5)}, 120));
  EXPECT_EQ(check_mesh(hull.mesh).shells, 1);
  EXPECT_LT(bounding_box(hull.mesh).sizes().maxCoeff(), 1.0f);
}

TEST_P(VisualHull, SeesThroughLenses) {
  for (const Lens& lens : {Lens{BrownConrady{-0.25, 0.08, 1e-3, -1e-3, 0}},
                           Lens{BrownConrady{0.15, 0.02, 0, 0, 0}}, Lens{KannalaBrandt{0.03, -0.01, 0, 0}}}) {
    const Rig rig = shapes::sphere_rig(
        {.cameras = 16, .distance = 1.5, .width = 200, .height = 160, .focal = 120, .lens = lens});
    const HullReport hull =
        hull_of(rig, shapes::render_mattes(rig, shapes::sphere({0.15, 0.1, 0}, 0.4)), at_resolution(80));
    EXPECT_THAT(hull.mesh, is_sound(GetParam()));
    EXPECT_NEAR(hull.volume / (kSphere * 0.064), 1.05, 0.05);
    for (double iou : hull.silhouette_iou) EXPECT_GT(iou, 0.985);
  }
}

TEST_P(VisualHull, TakesCamerasNearAndFar) {
  Rig rig = shapes::sphere_rig({.cameras = 8, .distance = 200, .focal = 12000});
  const Rig near = shapes::ring_rig({.cameras = 5, .distance = 0.9, .focal = 60}, 0.2);
  for (RigCamera c : near.cameras) {
    c.serial = "near-" + c.serial;
    rig.cameras.push_back(c);
  }
  const HullReport hull =
      hull_of(rig, shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.5)), at_resolution(64));
  EXPECT_THAT(hull.mesh, is_sound(GetParam()));
  EXPECT_NEAR(hull.volume / (kSphere * 0.125), 1.08, 0.08);
}

TEST_P(VisualHull, GivesTheSameBytesAtAnyThreadCount) {
  const Rig rig = shapes::ring_rig({.cameras = 7, .lens = BrownConrady{-0.1, 0.02, 0, 0, 0}});
  const auto mattes = shapes::render_mattes(rig, shapes::torus({0, 0, 0}, 0.4, 0.15));
  HullOptions options = at_resolution(70);
  options.threads = 1;
  const HullReport one = hull_of(rig, mattes, options);
  ASSERT_FALSE(one.mesh.empty());
  for (const int threads : {2, 5}) {
    options.threads = threads;
    const HullReport other = hull_of(rig, mattes, options);
    EXPECT_EQ(one.mesh.positions, other.mesh.positions);
    EXPECT_EQ(one.mesh.triangles, other.mesh.triangles);
    EXPECT_EQ(one.silhouette_iou, other.silhouette_iou);
  }
}

TEST(OctreeHull, SmoothsWithoutShrinking) {
  const Rig rig = shapes::sphere_rig({.cameras = 16, .focal = 250});
  const auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.5));
  HullOptions options = octree_at(64);
  const HullReport smooth = hull_of(rig, mattes, options);
  options.smoothing = 0;
  const HullReport raw = hull_of(rig, mattes, options);
  EXPECT_NE(raw.mesh.positions, smooth.mesh.positions);
  EXPECT_NEAR(smooth.volume / raw.volume, 1, 0.003);
}

// Any silhouettes at all, however inconsistent: the mesh is always sound.
TEST_P(VisualHull, IsSoundForDisturbedCamerasAndMattes) {
  int not_empty = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Random random(seed);
    Rig rig =
        shapes::ring_rig({.cameras = 3 + static_cast<int>(seed % 5), .width = 96, .height = 72, .focal = 80},
                         random.uniform(-1, 1.5));
    const auto shape =
        shapes::both(shapes::torus({0, 0, random.uniform(-0.2, 0.2)}, 0.45, random.uniform(0.03, 0.2)),
                     shapes::box({0, 0, 0.2}, {0.1, random.uniform(0.05, 0.6), 0.9}));
    std::vector<Matte> mattes = shapes::render_mattes(rig, shape);
    for (std::size_t i = 0; i < mattes.size(); ++i) {
      Image alpha = to_image(mattes[i]);
      for (std::uint8_t& a : alpha.pixels)
        if (random.uniform() < 0.01) a = static_cast<std::uint8_t>(random.uniform(0, 256));
      mattes[i] = make_matte({}, alpha);
      Rigid3& t = rig.cameras[i].cam_from_world;
      t.rotation = (t.rotation * Eigen::AngleAxisd(random.normal() * 0.01, Vector3d::UnitY())).normalized();
      t.translation += 0.02 * Vector3d(random.normal(), random.normal(), random.normal());
    }
    const HullReport hull =
        hull_of(rig, mattes, within({Vector3d(-0.8, -0.8, -0.6), Vector3d(0.8, 0.8, 0.9)}, 40));
    EXPECT_THAT(hull.mesh, is_sound(GetParam())) << "seed " << seed;
    not_empty += !hull.mesh.empty();
  }
  EXPECT_GT(not_empty, 18);
}

}  // namespace
}  // namespace floatstage::recon
