#include "pipeline/silhouette_check.h"

#include <cmath>
#include <cstdlib>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/random.h"
#include "core/synthetic/synthetic_studio.h"
#include "recon/visual_hull.h"
#include "tests/support/broken_mattes.h"
#include "tests/support/matchers.h"
#include "tests/support/turned_cameras.h"

namespace floatstage::pipeline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kShot = 12;  // instants, of which a run takes four

/// The performer as eight cameras see it, rendered once.
struct Stage {
  Rig rig = synthetic_rig({.width = 480, .height = 360});
  std::vector<InstantMattes> instants = std::vector<InstantMattes>(kShot);

  Stage() {
    const Result<SyntheticStudio> studio = SyntheticStudio::create(rig, {.seed = 3, .frame_rate = 30});
    parallel_for(instants.size(), 0, [&](std::size_t i) {
      for (std::size_t c = 0; c < rig.cameras.size(); ++c)
        instants[i].push_back(studio->shoot(static_cast<int>(c), 7 * static_cast<int>(i)).matte);
    });
  }
  std::vector<InstantMattes> four(int first) const {
    const auto at = [&](int i) { return instants[static_cast<std::size_t>((first + i) % kShot)]; };
    return {at(0), at(3), at(6), at(9)};
  }
};

const Stage& stage() {
  static const Stage made;
  return made;
}

TEST(SilhouetteCheck, NamesNobodyOnAnUntouchedRig) {
  const Result<SilhouetteCheck> check = check_silhouettes(stage().rig, stage().four(0), {});
  ASSERT_THAT(check, IsOk());
  EXPECT_THAT(test::named_by(*check), IsEmpty());
  EXPECT_FALSE(check->whole_rig);
  EXPECT_LT(check->usual_degrees, 0.03);
  EXPECT_THAT(sentences(*check), IsEmpty());
}

TEST(SilhouetteCheck, NamesACameraThatTurnedByThreeTenthsOfADegreeAndCorrectsIt) {
  const int seeds = test::seeds(3);
  for (int seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<InstantMattes> instants = stage().four(seed);
    const test::TurnedCamera turned = test::turn_one(stage().rig, 0.3, static_cast<std::uint64_t>(seed));
    const Result<SilhouetteCheck> check = check_silhouettes(turned.rig, instants, {});
    ASSERT_THAT(check, IsOk());
    EXPECT_THAT(test::named_by(*check), ElementsAre(turned.serial));
    EXPECT_LT(test::degrees_apart(stage().rig, check->corrected, turned.serial), 0.05);
    ASSERT_TRUE(check->iou_before && check->iou_after);
    EXPECT_LT(*check->iou_before, *check->iou_after);
    EXPECT_GT(*check->iou_after, test::mean_hull_iou(stage().rig, instants) - 0.003);
  }
}

TEST(SilhouetteCheck, TellsAWrongMatteFromAWrongPose) {
  std::vector<InstantMattes> instants = stage().four(1);
  Image cut = to_image(instants[1][5]);
  test::cut_upper_half(cut);
  instants[1][5] = make_matte({}, cut);
  const Result<SilhouetteCheck> check = check_silhouettes(stage().rig, instants, {});
  ASSERT_THAT(check, IsOk());
  EXPECT_THAT(test::named_by(*check), IsEmpty());
  EXPECT_EQ(check->cameras[5].wrong_mattes, 1);
  EXPECT_THAT(sentences(*check), ElementsAre(HasSubstr("camera 'cam05': the others contradict its matte")));
}

TEST(SilhouetteCheck, RefusesRigsThatAreTooSmall) {
  Rig three = stage().rig;
  three.cameras.resize(3);
  EXPECT_THAT(check_silhouettes(three, {InstantMattes(3)}, {}),
              FailsWith(ErrorCode::InvalidArgument, "4 cameras"));
}

TEST(SilhouetteCheck, SaysThatNothingIsMeasuredWithoutSubjects) {
  EXPECT_THAT(check_silhouettes(stage().rig, {InstantMattes(8)}, {}),
              FailsWith(ErrorCode::NotFound, "not measured"));
}

}  // namespace
}  // namespace floatstage::pipeline
