#include "pipeline/silhouettes/silhouette_check.h"

#include <cstdio>
#include <map>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/synthetic/synthetic_studio.h"
#include "pipeline/silhouettes/camera_groups.h"
#include "tests/support/broken_mattes.h"
#include "tests/support/long_tests.h"
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
  Rig rig;
  std::vector<InstantMattes> instants = std::vector<InstantMattes>(kShot);

  Stage(int width, int height, int cameras = 8)
      : rig(synthetic_rig({.cameras = cameras, .width = width, .height = height})) {
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
  static const Stage made(480, 360);
  return made;
}

// For many seeds: half the pixels.
const Stage& small_stage() {
  static const Stage made(336, 252);
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

/// The rig as it is: what the check says of it, and how well its hull explains the mattes.
struct Untouched {
  SilhouetteCheck check;
  double iou = 0;
};

// There are three choices of four instants.
const Untouched& untouched(const Stage& on, int first) {
  static std::map<std::pair<const Stage*, int>, Untouched> all;
  const auto [at, is_new] = all.try_emplace({&on, first % 3});
  if (is_new) {
    const std::vector<InstantMattes> instants = on.four(first);
    Result<SilhouetteCheck> check = check_silhouettes(on.rig, instants, {});
    EXPECT_THAT(check, IsOk());
    if (check) at->second = {*std::move(check), test::mean_hull_iou(on.rig, instants)};
  }
  return at->second;
}

void expect_named_and_corrected(const Stage& on, int seed) {
  SCOPED_TRACE(seed);
  const test::TurnedCamera turned = test::turn_one(on.rig, 0.3, static_cast<std::uint64_t>(seed));
  const Result<SilhouetteCheck> check = check_silhouettes(turned.rig, on.four(seed), {});
  ASSERT_THAT(check, IsOk());
  EXPECT_THAT(test::named_by(*check), ElementsAre(turned.serial));
  const double left = test::degrees_apart(on.rig, check->corrected, turned.serial);
  EXPECT_LT(left, 0.05);
  const Untouched& as_it_is = untouched(on, seed);
  EXPECT_THAT(test::named_by(as_it_is.check), IsEmpty());
  EXPECT_FALSE(as_it_is.check.whole_rig);
  ASSERT_TRUE(check->iou_before && check->iou_after);
  EXPECT_LT(*check->iou_before, *check->iou_after);
  // By one measure for both; the check's own leaves strands out.
  const double corrected = test::mean_hull_iou(check->corrected, on.four(seed));
  EXPECT_GT(corrected, as_it_is.iou - 0.003);
  std::printf("seed %d: %s, left %.4f degrees, IoU %.4f, untouched %.4f\n", seed, turned.serial.c_str(), left,
              corrected, as_it_is.iou);
}

TEST(SilhouetteCheck, NamesACameraThatTurnedByThreeTenthsOfADegreeAndCorrectsIt) {
  for (int seed = 0; seed < 3; ++seed) expect_named_and_corrected(stage(), seed);
}

// A hundred seeds, ten a test, so that they can be run side by side.
class SilhouetteCheckSeeds : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Tens, SilhouetteCheckSeeds, testing::Range(0, 10));

TEST_P(SilhouetteCheckSeeds, NameTheTurnedCameraAndNobodyOnTheUntouchedRig) {
  FLOATSTAGE_LONG_FORM(true);
  for (int seed = 10 * GetParam(); seed < 10 * GetParam() + 10; ++seed)
    expect_named_and_corrected(small_stage(), seed);
}

// Two of twelve are left out of a hull together, so that one of them may be the guilty one's neighbour in it.
TEST(SilhouetteCheck, FindsTheCameraThatTurnedAmongMany) {
  static const Stage many(336, 252, 12);
  ASSERT_EQ(CameraGroups(many.rig).count(), 6u);
  for (int seed = 0; seed < (wants_long_tests() ? 20 : 2); ++seed) expect_named_and_corrected(many, seed);
}

// As `process` asks: who it is, of eight cameras and of many.
TEST(SilhouetteCheck, NamesTheSameCameraQuickly) {
  static const Stage many(336, 252, 16);
  ASSERT_EQ(CameraGroups(many.rig, true).count(), 2u);
  const auto named = [](const Stage& on, const Rig& rig, int seed) {
    const std::vector<InstantMattes> four = on.four(seed), two = {four[0], four[2]};
    const Result<SilhouetteCheck> check = check_silhouettes(rig, two, {.quick = true});
    EXPECT_THAT(check, IsOk());
    return check ? test::named_by(*check) : std::vector<std::string>();
  };
  for (const Stage* on : {&many, &small_stage()}) {
    EXPECT_THAT(named(*on, on->rig, 0), IsEmpty());
    for (int seed = 0; seed < (wants_long_tests() ? 20 : 2); ++seed) {
      SCOPED_TRACE(seed);
      const test::TurnedCamera turned = test::turn_one(on->rig, 0.3, static_cast<std::uint64_t>(seed));
      EXPECT_THAT(named(*on, turned.rig, seed), ElementsAre(turned.serial));
    }
  }
}

TEST(CameraGroups, AreAsLargeAsLeavesEightOrHalf) {
  for (int cameras = 4; cameras < 40; ++cameras) {
    const CameraGroups groups(synthetic_rig({.cameras = cameras, .width = 64, .height = 48}), true);
    std::vector<int> members(groups.count(), 0);
    for (int c = 0; c < cameras; ++c) ++members[groups.of(static_cast<std::size_t>(c))];
    const int most = *std::max_element(members.begin(), members.end());
    EXPECT_TRUE(most == 1 || cameras - most >= 8) << cameras;
    EXPECT_EQ(groups.count() == 2, cameras >= 16) << cameras;
  }
}

TEST(CameraGroups, LeaveOutFewCamerasOneByOne) {
  const CameraGroups groups(stage().rig);
  EXPECT_EQ(groups.count(), 8u);
  std::set<std::size_t> all;
  for (std::size_t c = 0; c < 8; ++c) all.insert(groups.of(c));
  EXPECT_EQ(all.size(), 8u);
}

TEST(CameraGroups, OfManyCamerasHoldAFifthAtMostThatStandApart) {
  Rig rig = synthetic_rig({.cameras = 20, .width = 64, .height = 48});
  std::swap(rig.cameras[1], rig.cameras[10]);  // their order in the file does not matter
  const CameraGroups groups(rig);
  EXPECT_EQ(groups.count(), 5u);
  for (std::size_t a = 0; a < 20; ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (groups.of(a) == groups.of(b)) {
        const double apart =
            (rig.cameras[a].cam_from_world.center() - rig.cameras[b].cam_from_world.center()).norm();
        EXPECT_GT(apart, 1.5) << a << " and " << b;
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
