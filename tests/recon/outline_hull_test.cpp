// Hulls from outlines that were found elsewhere, as camera nodes do, in the place of mattes.

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "recon/mesh/mesh_check.h"
#include "recon/outline.h"
#include "recon/silhouette.h"
#include "recon/visual_hull.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Scene {
  Rig rig;
  std::vector<Matte> mattes;
};

Scene torus_and_box(double from_the_middle = 0) {
  Scene scene;
  scene.rig = shapes::ring_rig({.cameras = 7, .distance = 3, .width = 200, .height = 150, .focal = 170}, 0.6);
  for (RigCamera& camera : scene.rig.cameras) camera.model.lens = BrownConrady{-0.08, 0.02, 0.001, 0, 0};
  const Vector3d shift(from_the_middle, 0.02, 0.01);
  scene.mattes = shapes::render_mattes(
      scene.rig,
      shapes::both(shapes::torus(shift, 0.4, 0.12), shapes::box({-0.1, 0.1, 0.2}, {0.2, 0.2, 0.7})));
  return scene;
}

std::vector<Silhouette> outlines_of(const Scene& scene, double tolerance = 0.5) {
  std::vector<Silhouette> out;
  for (std::size_t c = 0; c < scene.mattes.size(); ++c)
    out.push_back(outline_of(scene.mattes[c], scene.rig.cameras[c].model, {.tolerance = tolerance}));
  return out;
}

void expect_equal(const HullReport& a, const HullReport& b) {
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.sources, b.sources);
  EXPECT_EQ(a.volume, b.volume);
}

Silhouette rectangle(double left, double top, double right, double bottom, bool hole = false) {
  Silhouette out;
  out.points = {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
  if (hole) std::reverse(out.points.begin(), out.points.end());
  out.starts = {0, 4};
  return out;
}

TEST(OutlineHull, IsThatOfTheMattesBitForBit) {
  const Scene scene = torus_and_box();
  for (const double tolerance : {0.0, 0.5, 1.5}) {
    HullOptions options;
    options.contour_tolerance = tolerance;
    options.quality = false;
    const Result<HullReport> from_mattes = visual_hull(scene.rig, scene.mattes, options);
    const Result<HullReport> from_outlines = visual_hull(scene.rig, outlines_of(scene, tolerance), options);
    ASSERT_THAT(from_mattes, IsOk());
    ASSERT_THAT(from_outlines, IsOk());
    EXPECT_GT(from_mattes->mesh.triangle_count(), 300u);
    expect_equal(*from_mattes, *from_outlines);
  }
}

TEST(OutlineHull, TakesPerformersWhoLeaveAPicture) {
  const Scene scene = torus_and_box(1.2);
  const std::vector<Silhouette> outlines = outlines_of(scene);
  EXPECT_TRUE(
      std::any_of(outlines.begin(), outlines.end(), [](const Silhouette& s) { return s.beyond_counts; }));
  const Result<HullReport> from_mattes = visual_hull(scene.rig, scene.mattes, {});
  const Result<HullReport> from_outlines = visual_hull(scene.rig, outlines, {});
  ASSERT_THAT(from_mattes, IsOk());
  ASSERT_THAT(from_outlines, IsOk());
  expect_equal(*from_mattes, *from_outlines);
}

TEST(OutlineHull, KnowsNothingBeyondAPictureThatDoesNotHoldTheVolume) {
  const Scene scene = torus_and_box();
  HullOptions options;
  options.volume = Eigen::AlignedBox3d(Vector3d(-2, -2, -1), Vector3d(2, 2, 1));
  const Result<HullReport> from_mattes = visual_hull(scene.rig, scene.mattes, options);
  const Result<HullReport> from_outlines = visual_hull(scene.rig, outlines_of(scene), options);
  ASSERT_THAT(from_mattes, IsOk());
  ASSERT_THAT(from_outlines, IsOk());
  // The pictures' borders are drawn in other places, within the tolerance.
  EXPECT_NEAR(from_outlines->volume / from_mattes->volume, 1, 2e-3);
  EXPECT_TRUE(check_mesh(from_outlines->mesh).watertight);
}

TEST(OutlineHull, LeavesOutCamerasOfWhichNothingIsKnown) {
  Scene scene = torus_and_box();
  std::vector<Silhouette> outlines = outlines_of(scene);
  outlines[2].clear();
  scene.mattes[2] = Matte{};
  const Result<HullReport> from_mattes = visual_hull(scene.rig, scene.mattes, {});
  const Result<HullReport> from_outlines = visual_hull(scene.rig, outlines, {});
  ASSERT_THAT(from_outlines, IsOk());
  expect_equal(*from_mattes, *from_outlines);
  EXPECT_TRUE(std::isnan(from_outlines->silhouette_iou[2]));
  EXPECT_GT(from_outlines->silhouette_iou[1], 0.99);
}

TEST(OutlineHull, SaysThatACameraSeesOnlyBackground) {
  Scene scene = torus_and_box();
  scene.mattes[1] = make_matte({}, Image(200, 150, 1, 0));
  const Result<HullReport> hull = visual_hull(scene.rig, outlines_of(scene), {});
  ASSERT_THAT(hull, IsOk());
  EXPECT_TRUE(hull->mesh.empty());
  EXPECT_THAT(hull->remarks, testing::Contains(testing::HasSubstr("camera 'c1' sees only background")));
  for (Matte& matte : scene.mattes) matte = scene.mattes[1];
  EXPECT_THAT(visual_hull(scene.rig, outlines_of(scene), {}),
              FailsWith(ErrorCode::BadData, "empty silhouette"));
}

TEST(OutlineHull, VotesADamagedOutlineDown) {
  Scene scene;
  scene.rig = shapes::sphere_rig({.cameras = 10, .focal = 180});
  scene.mattes = shapes::render_mattes(
      scene.rig, shapes::both(shapes::sphere({0, 0, 0.3}, 0.25), shapes::sphere({0, 0, -0.2}, 0.35)));
  Image broken = to_image(scene.mattes[4]);
  std::fill(broken.pixels.begin(),
            broken.pixels.begin() + static_cast<std::ptrdiff_t>(broken.pixels.size() / 2), 0);
  scene.mattes[4] = make_matte({}, broken);
  HullOptions options;
  options.voting = HullVoting::Auto;
  const Result<HullReport> hull = visual_hull(scene.rig, outlines_of(scene), options);
  ASSERT_THAT(hull, IsOk());
  EXPECT_THAT(hull->voted_down, testing::ElementsAre(4));
}

TEST(OutlineHull, CanBeCarvedByTheOctreeToo) {
  const Scene scene = torus_and_box();
  HullOptions options;
  options.method = HullMethod::Octree;
  options.resolution = 96;
  const Result<HullReport> carved = visual_hull(scene.rig, outlines_of(scene, 0), options);
  const Result<HullReport> exact = visual_hull(scene.rig, outlines_of(scene, 0), {});
  ASSERT_THAT(carved, IsOk());
  EXPECT_NEAR(carved->volume / exact->volume, 1, 0.03);
}

TEST(OutlineHull, MendsOutlinesThatCrossThemselvesALittle) {
  const Scene scene = torus_and_box();
  std::vector<Silhouette> outlines = outlines_of(scene, 0.25);
  for (Silhouette& outline : outlines) {
    const Silhouette sent = outline;
    for (std::size_t i = 1; is_simple(outline);
         ++i) {  // two points in the wrong order, where that makes a crossing
      outline = sent;
      std::swap(outline.points.at(i), outline.points.at(i + 1));
    }
  }
  const Result<HullReport> hull = visual_hull(scene.rig, outlines, {});
  ASSERT_THAT(hull, IsOk());
  const MeshCheck check = check_mesh(hull->mesh);
  EXPECT_TRUE(check.watertight && check.manifold && check.oriented) << check.summary();
}

TEST(OutlineHull, TakesPointsThatFellTogetherForOne) {
  const Scene scene = torus_and_box();
  const std::vector<Silhouette> outlines = outlines_of(scene);
  std::vector<Silhouette> repeated = outlines;
  for (Silhouette& outline : repeated) {
    outline.points.insert(outline.points.begin() + 5, 2, outline.points[5]);
    outline.points.insert(outline.points.begin() + outline.starts[1] + 2, outline.points[0]);
    for (int k = 1; k <= outline.polygons(); ++k) outline.starts[k] += 3;
  }
  const Result<HullReport> a = visual_hull(scene.rig, outlines, {}), b = visual_hull(scene.rig, repeated, {});
  ASSERT_THAT(a, IsOk());
  ASSERT_THAT(b, IsOk());
  EXPECT_EQ(b->work.points, a->work.points);
  EXPECT_NEAR(b->volume / a->volume, 1, 1e-9);
}

TEST(OutlineHull, LeavesOutSpikesWithoutWidth) {
  const Scene scene = torus_and_box();
  const std::vector<Silhouette> outlines = outlines_of(scene);
  std::vector<Silhouette> spiky = outlines;
  for (Silhouette& outline : spiky) {  // out and back from the first point, in two steps
    const Vector2d from = outline.points[0], away = from + Vector2d(-7, 3), half = from + Vector2d(-3.5, 1.5);
    outline.points.insert(outline.points.begin() + 1, {half, away, half, from});
    for (int k = 1; k <= outline.polygons(); ++k) outline.starts[k] += 4;
  }
  const Result<HullReport> a = visual_hull(scene.rig, outlines, {}), b = visual_hull(scene.rig, spiky, {});
  ASSERT_THAT(a, IsOk());
  ASSERT_THAT(b, IsOk());
  EXPECT_NEAR(b->volume / a->volume, 1, 1e-9);
}

TEST(OutlineHull, RefusesAnOutlineThatTurnsInsideOutWhereItIsMended) {
  const Scene scene = torus_and_box();
  std::vector<Silhouette> outlines = outlines_of(scene);
  Silhouette knot;  // found by fuzzing: what is left of it without its crossings bounds the wrong side
  for (const auto& [x, y] : {std::pair{0.0, 0.0},
                             {36.0, 20.0},
                             {36.0, 26.0},
                             {18.0, 20.0},
                             {0.0, 24.0},
                             {44.0, 28.0},
                             {24.0, 24.0},
                             {24.0, 24.25}})
    knot.points.emplace_back(x, y);
  knot.starts = {0, 8};
  outlines[3] = knot;
  EXPECT_THAT(visual_hull(scene.rig, outlines, {}),
              FailsWith(ErrorCode::BadData, "camera 'c3': without its lens"));
}

TEST(OutlineHull, NamesTheCameraWhoseOutlineIsOfNoUse) {
  const Scene scene = torus_and_box();
  const std::vector<Silhouette> good = outlines_of(scene);
  const auto expect = [&](const Silhouette& bad, const std::string& words) {
    std::vector<Silhouette> outlines = good;
    outlines[3] = bad;
    const Result<HullReport> hull = visual_hull(scene.rig, outlines, {});
    EXPECT_THAT(hull, FailsWith(ErrorCode::BadData, "camera 'c3'"));
    EXPECT_THAT(hull, FailsWith(ErrorCode::BadData, words));
  };
  expect(rectangle(20, 20, 60, 60, true), "right of every edge");
  Silhouette nested = rectangle(20, 20, 60, 60);
  for (const Vector2d& p : rectangle(30, 30, 50, 50).points) nested.points.push_back(p);
  nested.starts.push_back(8);
  expect(nested, "right of every edge");
  Silhouette cut = rectangle(20, 20, 60, 60);
  cut.starts = {0, 5};
  expect(cut, "share out");
  cut.starts = {0, 2, 4};
  expect(cut, "fewer than three");
  expect(rectangle(20, 20, 60, 1e6), "far outside");
  expect(rectangle(20, std::nan(""), 60, 30), "far outside");
  Silhouette noise;
  noise.starts = {0};
  while (noise.points.size() <= 20000) {
    const double y = 0.005 * static_cast<double>(noise.points.size());
    for (const Vector2d& p : rectangle(20, y, 60, y + 0.01).points) noise.points.push_back(p);
    noise.starts.push_back(static_cast<int>(noise.points.size()));
  }
  expect(noise, "points, more than");
  std::vector<Silhouette> few(2);
  EXPECT_THAT(visual_hull(scene.rig, few, {}),
              FailsWith(ErrorCode::InvalidArgument, "2 outlines for 7 cameras"));
}

TEST(Filled, GivesThePixelsBackThatWereTraced) {
  Random random(7);
  for (const double density : {0.02, 0.3, 0.6, 0.97}) {
    Image image(60, 45, 1);
    for (std::uint8_t& alpha : image.pixels) alpha = random.uniform() < density ? 255 : 0;
    const Matte matte = make_matte({}, image);
    const CameraModel model{
        .width = 60, .height = 45, .fx = 50, .fy = 50, .cx = 30, .cy = 22, .skew = 0, .lens = {}};
    const Silhouette outline = outline_of(matte, model, {.tolerance = 0});
    EXPECT_EQ(to_image(filled(outline, 60, 45)), image) << density;
  }
}

TEST(Filled, IsAllSubjectOrUnknownWithoutPoints) {
  EXPECT_TRUE(filled(Silhouette{}, 8, 6).empty());
  Silhouette everywhere;
  everywhere.beyond_counts = true;
  EXPECT_EQ(coverage(filled(everywhere, 8, 6)), 1);
}

TEST(Outlines, OfAWorkspaceAreThoseWithoutOne) {
  const Scene scene = torus_and_box();
  OutlineWorkspace workspace;
  Silhouette kept;
  for (std::size_t c = 0; c < scene.mattes.size(); ++c) {
    CameraModel model = scene.rig.cameras[c].model;
    if (c % 2) model.lens = {};
    outline_of(scene.mattes[c], model, {}, workspace, kept);
    const Silhouette fresh = outline_of(scene.mattes[c], model);
    EXPECT_EQ(kept.points, fresh.points);
    EXPECT_EQ(kept.starts, fresh.starts);
  }
}

}  // namespace
}  // namespace floatstage::recon
