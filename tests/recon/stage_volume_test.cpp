#include "recon/stage_volume.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recon/mesh/mesh_check.h"
#include "recon/mesh/mesh_mask.h"
#include "recon/outline.h"
#include "recon/silhouette_audit.h"
#include "recon/visual_hull.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using testing::IsEmpty;
using testing::SizeIs;

StageVolume stage_of(const Rig& rig, const std::vector<Matte>& mattes) {
  StageVolume stage;
  StageFinder finder;
  EXPECT_TRUE(finder.find(rig, HullInput(rig, std::span<const Matte>(mattes), 1), stage));
  return stage;
}

std::vector<SilhouetteVerdict> audited(const Rig& rig, const std::vector<Matte>& mattes) {
  const HullInput input(rig, std::span<const Matte>(mattes), 1);
  StageFinder finder;
  StageVolume stage;
  EXPECT_TRUE(finder.find(rig, input, stage));
  return SilhouetteAudit().audit(rig, input, finder);
}

/// Cameras that each see a part of the stage: two bodies, further apart than any picture is wide.
Rig narrow_rig() {
  Rig rig;
  for (const double x : {-0.7, 0.7}) {
    Rig ring = shapes::ring_rig({.cameras = 6, .target = {x, 0, 0}, .focal = 260}, x > 0 ? 0.9 : 0.7);
    for (RigCamera& camera : ring.cameras) {
      camera.serial = (x < 0 ? "left-" : "right-") + camera.serial;
      rig.cameras.push_back(camera);
    }
  }
  return rig;
}

shapes::Shape two_apart() {
  return shapes::both(shapes::sphere({-0.7, 0, 0}, 0.25), shapes::sphere({0.7, 0.1, 0}, 0.2));
}

TEST(StageVolume, HoldsTheSubjectAndLittleMore) {
  const Rig rig = shapes::ring_rig({.cameras = 8});
  const StageVolume stage =
      stage_of(rig, shapes::render_mattes(rig, shapes::box({0.2, 0.1, 0}, {0.4, 0.3, 0.6})));
  EXPECT_TRUE(stage.box.contains(Eigen::AlignedBox3d(Vector3d(0, -0.05, -0.3), Vector3d(0.4, 0.25, 0.3))));
  EXPECT_LT(stage.box.sizes().maxCoeff(), 1.3);
  EXPECT_EQ(stage.cameras, 3);
  EXPECT_THAT(stage.partial, testing::Each(0));
  for (const double share : stage.unexplained) EXPECT_EQ(share, 0);
}

TEST(StageVolume, KnowsWhoSeesOnlyAPart) {
  const Rig rig = narrow_rig();
  const StageVolume stage = stage_of(rig, shapes::render_mattes(rig, two_apart()));
  EXPECT_TRUE(stage.box.contains(Vector3d(-0.9, 0, 0)) && stage.box.contains(Vector3d(0.85, 0.1, 0)));
  EXPECT_GE(std::count(stage.partial.begin(), stage.partial.end(), 1), 6);
}

TEST(StageVolume, GrowsToWhereOnlyTwoCamerasLook) {
  Rig rig = shapes::ring_rig({.cameras = 8}, 0.8);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (c != 0 && c != 2) rig.cameras[c].model.cy = 40;  // the upper part is above their pictures
  const auto shape = shapes::both(shapes::sphere({0, 0, 0}, 0.3), shapes::box({0, 0, 0.6}, {0.1, 0.1, 0.8}));
  const StageVolume stage = stage_of(rig, shapes::render_mattes(rig, shape));
  EXPECT_EQ(stage.cameras, 2);
  EXPECT_GT(stage.box.max().z(), 0.95);
}

TEST(StageVolume, IsTheSameFromOutlines) {
  const Rig rig = narrow_rig();
  const auto mattes = shapes::render_mattes(rig, two_apart());
  std::vector<Silhouette> outlines;
  for (std::size_t c = 0; c < mattes.size(); ++c)
    outlines.push_back(outline_of(mattes[c], rig.cameras[c].model));
  StageFinder finder;
  StageVolume from_outlines;
  ASSERT_TRUE(finder.find(rig, HullInput(rig, std::span<const Silhouette>(outlines), 1), from_outlines));
  const StageVolume stage = stage_of(rig, mattes);
  EXPECT_LT((stage.box.min() - from_outlines.box.min()).norm(), 0.15);
  EXPECT_LT((stage.box.max() - from_outlines.box.max()).norm(), 0.15);
  EXPECT_EQ(stage.cameras, from_outlines.cameras);
}

TEST(VisualHullOfPartialViews, HasBothBodiesThoughNoCameraSeesBoth) {
  const Rig rig = narrow_rig();
  const auto mattes = shapes::render_mattes(rig, two_apart());
  const Result<HullReport> hull = visual_hull(rig, mattes, {});
  ASSERT_THAT(hull, IsOk());
  EXPECT_EQ(check_mesh(hull->mesh).shells, 2);
  EXPECT_FALSE(hull->cut);
  EXPECT_NEAR(bounding_box(hull->mesh).min().x(), -0.95, 0.04);
  EXPECT_NEAR(bounding_box(hull->mesh).max().x(), 0.9, 0.04);
  for (const double iou : hull->silhouette_iou) EXPECT_GT(iou, 0.97);
}

/// A ring around a figure of two spheres, and whom something was done to.
struct Studio {
  Rig rig = shapes::ring_rig({.cameras = 8, .width = 320, .height = 240, .focal = 300});
  std::vector<Matte> mattes = shapes::render_mattes(
      rig, shapes::both(shapes::sphere({0, 0, 0.35}, 0.2), shapes::box({0, 0, -0.2}, {0.4, 0.3, 0.9})));

  void cut_half(std::size_t camera) {
    Image alpha = to_image(mattes[camera]);
    std::fill(alpha.pixels.begin(),
              alpha.pixels.begin() + static_cast<std::ptrdiff_t>(alpha.pixels.size() / 2), 0);
    mattes[camera] = make_matte({}, alpha);
  }
  void add_block(std::size_t camera) {
    Image alpha = to_image(mattes[camera]);
    for (int y = 180; y < 230; ++y)
      for (int x = 20; x < 70; ++x) alpha.at(x, y)[0] = 255;
    mattes[camera] = make_matte({}, alpha);
  }
};

TEST(SilhouetteAudit, AcquitsTrueSilhouettes) {
  const Studio studio;
  EXPECT_THAT(audited(studio.rig, studio.mattes), IsEmpty());
}

TEST(SilhouetteAudit, NamesTwoOfEightThatLackHalfTheBodyAndHowMuch) {
  Studio studio;
  studio.cut_half(1);
  studio.cut_half(5);
  const std::vector<SilhouetteVerdict> verdicts = audited(studio.rig, studio.mattes);
  ASSERT_THAT(verdicts, SizeIs(2));
  for (const SilhouetteVerdict& verdict : verdicts) {
    EXPECT_TRUE(verdict.camera == 1 || verdict.camera == 5) << verdict.camera;
    EXPECT_NEAR(verdict.lost, 0.5, 0.2);
    EXPECT_LT(verdict.gained, SilhouetteAudit::kAllowed);
  }
}

TEST(SilhouetteAudit, NamesAMatteWithMoreThanTheOthersConfirm) {
  Studio studio;
  studio.add_block(3);
  const std::vector<SilhouetteVerdict> verdicts = audited(studio.rig, studio.mattes);
  ASSERT_THAT(verdicts, SizeIs(1));
  EXPECT_EQ(verdicts[0].camera, 3);
  EXPECT_GT(verdicts[0].gained, 0.05);
  EXPECT_LT(verdicts[0].lost, SilhouetteAudit::kAllowed);
}

TEST(VotedHull, HealsHalfABodyCutInTwoOfEightCameras) {
  const Studio whole;
  Studio broken;
  broken.cut_half(1);
  broken.cut_half(5);
  HullOptions options;
  options.voting = HullVoting::Auto;
  const Result<HullReport> healed = visual_hull(broken.rig, broken.mattes, options);
  ASSERT_THAT(healed, IsOk());
  EXPECT_THAT(healed->voted_down, testing::UnorderedElementsAre(1, 5));
  EXPECT_FALSE(healed->contradictory);
  double sum = 0;
  for (std::size_t c = 0; c < whole.mattes.size(); ++c)
    sum += iou(mesh_mask(whole.rig.cameras[c], healed->mesh), whole.mattes[c]);
  EXPECT_GT(sum / static_cast<double>(whole.mattes.size()), 0.95);
}

TEST(HullCrumbs, AreDroppedAndCountedAndThinPartsStay) {
  Rig rig = shapes::ring_rig({.cameras = 8, .width = 320, .height = 240, .focal = 300});
  // A stick of four pixels, and a speck of less than one.
  const auto shape =
      shapes::both(shapes::both(shapes::sphere({0, 0, 0}, 0.3), shapes::box({0.6, 0, 0}, {0.04, 0.04, 0.5})),
                   shapes::sphere({-0.5, 0, 0.2}, 0.007));
  const auto mattes = shapes::render_mattes(rig, shape);
  HullOptions options;
  options.contour_tolerance = 0.1;
  options.keep_crumbs = true;
  const Result<HullReport> all = visual_hull(rig, mattes, options);
  options.keep_crumbs = false;
  const Result<HullReport> kept = visual_hull(rig, mattes, options);
  ASSERT_THAT(all, IsOk());
  ASSERT_THAT(kept, IsOk());
  EXPECT_EQ(check_mesh(kept->mesh).shells, 2);
  EXPECT_EQ(kept->crumbs, check_mesh(all->mesh).shells - 2);
  EXPECT_NEAR(kept->volume + kept->crumb_volume, all->volume, 1e-9);
  EXPECT_EQ(kept->sources.size(), kept->mesh.triangle_count());
}

}  // namespace
}  // namespace floatstage::recon
