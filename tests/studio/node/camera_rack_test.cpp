#include "studio/node/camera_rack.h"

#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"
#include "recon/outline.h"
#include "tests/support/cast_shadows.h"
#include "tests/support/matchers.h"

namespace floatstage::studio {
namespace {

// A furnished room, whose empty stage was shot, and somebody in it.
class ARackBeforeARoom : public testing::Test {
 protected:
  ARackBeforeARoom() {
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i) {
      SyntheticShot shot = studio_.shoot(static_cast<int>(i), 5);
      pictures_.push_back(*to_rgb(shot.frame));
      truth_.push_back(shot.matte);
    }
  }
  CameraRack rack(std::size_t plates) const {
    std::vector<matting::KeySamples> samples;
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i)
      samples.push_back({.pictures = {studio_.plate(static_cast<int>(i))}, .empty_stage = i < plates});
    Result<CameraRack> made = CameraRack::make(rig_, "plate", std::move(samples));
    EXPECT_THAT(made, IsOk());
    return std::move(*made);
  }
  void cast_shadows() {
    for (std::size_t i = 0; i < pictures_.size(); ++i)
      floatstage::cast_shadows(rig_.cameras[i], truth_[i], pictures_[i]);
  }
  // Mean over the cameras, of outlines.
  double iou_of(CameraRack rack, const NodeQuality& quality = {}) const {
    TimedSet set;
    set.produced.resize(pictures_.size());
    for (const Image& p : pictures_) set.images.frames.push_back(make_frame({}, p));
    SceneTimes times;
    std::vector<std::shared_ptr<const CameraView>> views;
    rack.look(set, {}, quality, 2, times, views);
    EXPECT_EQ(rack.trouble(), "");
    double sum = 0;
    for (std::size_t i = 0; i < views.size(); ++i)
      sum += iou(recon::filled(views[i]->outline, views[i]->width, views[i]->height), truth_[i]);
    return sum / static_cast<double>(views.size());
  }

  Rig rig_ = synthetic_rig({.cameras = 8, .width = 480, .height = 360});
  SyntheticStudio studio_ = *SyntheticStudio::create(
      rig_, {.seed = 4, .samples = 4, .stage = SyntheticStage::Room, .defects = {.noise = 1}});
  std::vector<Image> pictures_;
  std::vector<Matte> truth_;
};

TEST_F(ARackBeforeARoom, KeysNoHardShadowsOnTheFloor) {
  const double without = iou_of(rack(8)), small = iou_of(rack(8), {.shrink = 2});
  cast_shadows();
  EXPECT_GE(iou_of(rack(8)), without - 0.01);
  EXPECT_GE(iou_of(rack(8), {.shrink = 2}), small - 0.02);
}

TEST_F(ARackBeforeARoom, HasToSeeItsEmptyStageInThreeCamerasForThat) {
  const double without = iou_of(rack(8));
  cast_shadows();
  EXPECT_LE(iou_of(rack(2)), without - 0.1) << "else this test shows nothing";
}

}  // namespace
}  // namespace floatstage::studio
