#include "studio/live/reconstruction.h"

#include "core/check.h"
#include "recon/outline.h"
#include "tests/studio/synthetic_shots.h"

namespace floatstage::studio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class AReconstruction : public testing::Test {
 protected:
  AReconstruction() {
    for (int i = 0; i < 6; ++i) {
      CameraView view;
      view.serial = shots_.rig.cameras[static_cast<std::size_t>(i)].serial;
      view.epoch = 3;
      view.instant = {3000};
      view.exposed = {3000 + i};
      view.produced = {9000 - 10 * i};
      view.width = 320;
      view.height = 240;
      view.known = true;
      view.outline = recon::outline_of(shots_.studio.shoot(i, 0).matte,
                                       shots_.rig.cameras[static_cast<std::size_t>(i)].model);
      views_.push_back(view);
    }
  }
  Result<StudioScene> made() {
    std::vector<std::shared_ptr<const CameraView>> shared;
    for (const CameraView& view : views_) shared.push_back(std::make_shared<const CameraView>(view));
    if (Result<void> ok = reconstruction_.make(shared, 1, scene_); !ok) return forward(ok);
    return scene_;
  }

  SyntheticShots shots_{6};
  std::vector<CameraView> views_;
  StudioScene scene_;  // made again and again
  Reconstruction reconstruction_{shots_.rig, "abc"};
};

TEST_F(AReconstruction, IsTheHullOfTheOutlinesWithTheirTimes) {
  const Result<StudioScene> scene = made();
  ASSERT_THAT(scene, IsOk());
  const double truth = signed_volume(shots_.studio.performer(0));
  EXPECT_GT(signed_volume(scene->mesh), truth);
  EXPECT_LT(signed_volume(scene->mesh), 2 * truth);
  EXPECT_EQ(scene->epoch, 3U);
  EXPECT_EQ(scene->instant.ns, 3000);
  EXPECT_EQ(scene->produced.ns, 8950) << "the first picture's";
  EXPECT_EQ(scene->rig_sha256, "abc");
  ASSERT_THAT(scene->cameras, SizeIs(6));
  EXPECT_EQ(scene->cameras[2].exposed.ns, 3002);
}

TEST_F(AReconstruction, DoesNotCarveWithCamerasThatKnowNothing) {
  const double before = signed_volume(made()->mesh);
  views_[1].known = false;
  views_[1].outline.clear();
  views_.pop_back();
  const Result<StudioScene> scene = made();
  ASSERT_THAT(scene, IsOk());
  EXPECT_THAT(scene->cameras, SizeIs(4));
  EXPECT_GT(signed_volume(scene->mesh), before);
}

TEST_F(AReconstruction, TakesViewsInAnyOrderAndLeavesStrangersOut) {
  const Mesh before = made()->mesh;
  std::swap(views_[0], views_[4]);
  views_.push_back(views_[2]);
  views_.back().serial = "stranger";
  const Result<StudioScene> scene = made();
  ASSERT_THAT(scene, IsOk());
  EXPECT_EQ(scene->mesh.triangles, before.triangles);
  EXPECT_THAT(scene->cameras, SizeIs(6));
}

TEST_F(AReconstruction, OfAnEmptyStageHasNoSurfaceAndSaysWhy) {
  EXPECT_FALSE(made()->mesh.empty()) << "and what was there before does not matter";
  for (CameraView& view : views_) {
    view.outline.clear();
    view.outline.beyond_counts = true;
    for (const auto& [x, y] : {std::pair(0, 0), std::pair(0, 240), std::pair(320, 240), std::pair(320, 0)})
      view.outline.points.emplace_back(x, y);
    view.outline.starts = {0, 4};
  }
  const Result<StudioScene> scene = made();
  ASSERT_THAT(scene, IsOk());
  EXPECT_THAT(scene->mesh.triangles, IsEmpty());
  EXPECT_THAT(reconstruction_.remark(), HasSubstr("no camera shows any subject"));
}

TEST_F(AReconstruction, RefusesPicturesOfAnotherSize) {
  views_[3].width = 640;
  EXPECT_THAT(made(), FailsWith(ErrorCode::InvalidArgument, "640x240"));
}

}  // namespace
}  // namespace floatstage::studio
