#include "pipeline/matte/consistent.h"

#include <algorithm>

#include "core/matte.h"
#include "core/synthetic/synthetic_studio.h"
#include "core/text.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

using testing::Contains;
using testing::HasSubstr;

// Eight cameras around the synthetic performer, their pictures and the truth.
class Stage {
 public:
  explicit Stage(bool green) : Stage(green ? SyntheticStage::Green : SyntheticStage::Black, 1, 320) {}
  Stage(SyntheticStage stage, std::uint64_t seed, int width)
      : studio_(
            SyntheticStudio::create(synthetic_rig({.cameras = 8, .width = width, .height = width * 3 / 4}),
                                    {.seed = seed, .samples = 4, .stage = stage, .defects = {.noise = 1}})) {
    EXPECT_THAT(studio_, IsOk());
  }
  const Rig& rig() const { return studio_->published_rig(); }
  Image plate(int camera) const { return studio_->plate(camera); }
  void shoot(int frame) {
    pictures.clear();
    truth.clear();
    for (int i = 0; i < 8; ++i) {
      const SyntheticShot shot = studio_->shoot(i, frame);
      pictures.push_back(*to_rgb(shot.frame));
      truth.push_back(shot.matte);
    }
  }
  std::vector<double> ious(const ConsistentMattes& made) const {
    std::vector<double> all;
    for (std::size_t i = 0; i < truth.size(); ++i)
      all.push_back(iou(make_matte({}, made.mattes[i]), truth[i]));
    return all;
  }

  std::vector<Image> pictures;
  std::vector<Matte> truth;

 private:
  Result<SyntheticStudio> studio_;
};

ConsistentMatting matting_for(const Rig& rig, int threads = 2) {
  Result<ConsistentMatting> matting = ConsistentMatting::create(rig, {.voxels = 150'000, .threads = threads});
  EXPECT_THAT(matting, IsOk());
  return std::move(*matting);
}

double mean(const std::vector<double>& all) {
  double sum = 0;
  for (const double a : all) sum += a;
  return sum / static_cast<double>(all.size());
}

double least(const std::vector<double>& all) { return *std::min_element(all.begin(), all.end()); }

class OnEveryStage : public testing::TestWithParam<bool> {};

TEST_P(OnEveryStage, ConsistentMattingFindsThePerformerWithoutAKeyAndFollowsHim) {
  Stage stage(GetParam());
  ConsistentMatting matting = matting_for(stage.rig());
  for (const int frame : {0, 1}) {
    stage.shoot(frame);
    const Result<ConsistentMattes> made = matting.matte(stage.pictures);
    ASSERT_THAT(made, IsOk());
    EXPECT_GE(mean(stage.ious(*made)), 0.93) << frame;
    EXPECT_GE(least(stage.ious(*made)), 0.90) << frame;
    EXPECT_TRUE(made->trusted) << testing::PrintToString(made->remarks);
    EXPECT_LE(made->turns, frame == 0 ? ConsistentOptions().turns : ConsistentOptions().later_turns);
    for (const ConsistentView& v : made->views) {
      EXPECT_TRUE(v.pictured);
      EXPECT_GT(v.sure, 0.8);
      EXPECT_EQ(v.border, 0);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Consistent, OnEveryStage, testing::Values(true, false),
                         [](const auto& each) { return each.param ? "GreenCloth" : "Black"; });

// Of every stage that the studio has, at the size that `synthesize` takes.
class OnStages : public testing::TestWithParam<std::tuple<SyntheticStageName, int>> {};

TEST_P(OnStages, ConsistentMattesHoldOrSayThatTheyDoNot) {
  const auto& [named, seed] = GetParam();
  FLOATSTAGE_LONG_FORM(seed > 1);
  Stage stage(named.stage, static_cast<std::uint64_t>(seed), 640);
  stage.shoot(5);
  Result<ConsistentMatting> matting = ConsistentMatting::create(stage.rig(), {});
  ASSERT_THAT(matting, IsOk());
  const Result<ConsistentMattes> made = matting->matte(stage.pictures);
  ASSERT_THAT(made, IsOk());
  const bool shares_colours =
      named.stage == SyntheticStage::Room || named.stage == SyntheticStage::GreenClothes;
  EXPECT_EQ(made->trusted, !shares_colours) << testing::PrintToString(made->remarks);
  if (!made->trusted) return;
  EXPECT_GE(mean(stage.ious(*made)), 0.965);
  EXPECT_GE(least(stage.ious(*made)), 0.93);
}
INSTANTIATE_TEST_SUITE_P(Consistent, OnStages,
                         testing::Combine(testing::ValuesIn(synthetic_stages()), testing::Range(1, 6)),
                         [](const auto& each) {
                           std::string name;
                           for (const char c : std::string(std::get<0>(each.param).name))
                             name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name + std::to_string(std::get<1>(each.param));
                         });

TEST(Consistent, NamesACameraThatSeesOnlyTheRoom) {
  Stage stage(true);
  stage.shoot(0);
  stage.pictures[2] = stage.plate(2);
  ConsistentMatting matting = matting_for(stage.rig());
  const Result<ConsistentMattes> made = matting.matte(stage.pictures);
  ASSERT_THAT(made, IsOk());
  EXPECT_FALSE(made->trusted);
  EXPECT_THAT(made->remarks, Contains(HasSubstr("cam02")));
  EXPECT_GE(stage.ious(*made)[5], 0.9);  // the others do not suffer
}

TEST(Consistent, SaysThatNobodyIsThereRatherThanInventingSomebody) {
  Stage stage(true);
  std::vector<Image> plates;
  for (int i = 0; i < 8; ++i) plates.push_back(stage.plate(i));
  ConsistentMatting matting = matting_for(stage.rig());
  const Result<ConsistentMattes> made = matting.matte(plates);
  ASSERT_THAT(made, IsOk());
  EXPECT_FALSE(made->trusted);
  EXPECT_FALSE(made->remarks.empty());
}

TEST(Consistent, DoesWithoutACameraThatMissedTheInstant) {
  Stage stage(true);
  stage.shoot(0);
  stage.pictures[4] = {};
  ConsistentMatting matting = matting_for(stage.rig());
  const Result<ConsistentMattes> made = matting.matte(stage.pictures);
  ASSERT_THAT(made, IsOk());
  EXPECT_TRUE(made->mattes[4].empty());
  EXPECT_FALSE(made->views[4].pictured);
  EXPECT_FALSE(made->mattes[3].empty());
}

TEST(Consistent, IsTheSameAtAnyNumberOfThreads) {
  Stage stage(false);
  stage.shoot(0);
  const Result<ConsistentMattes> one = matting_for(stage.rig(), 1).matte(stage.pictures),
                                 three = matting_for(stage.rig(), 3).matte(stage.pictures);
  ASSERT_TRUE(one && three);
  EXPECT_TRUE(one->mattes == three->mattes);
}

TEST(Consistent, APersonsWordIsFinal) {
  Stage stage(true);
  stage.shoot(0);
  std::vector<Image> said(8);
  said[0] = Image(320, 240, 1, 128);
  for (int y = 100; y < 140; ++y) *said[0].at(160, y) = 0;  // through the performer's chest
  *said[0].at(10, 10) = 255;
  ConsistentMatting matting = matting_for(stage.rig());
  const Result<ConsistentMattes> made = matting.matte(stage.pictures, said);
  ASSERT_THAT(made, IsOk());
  EXPECT_EQ(*made->mattes[0].at(160, 120), 0);
  EXPECT_EQ(*made->mattes[0].at(10, 10), 255);
}

TEST(Consistent, RefusesWhatDoesNotFitAndStopsWhenAsked) {
  Stage stage(true);
  stage.shoot(0);
  EXPECT_THAT(ConsistentMatting::create(stage.rig(), {.turns = 0}),
              FailsWith(ErrorCode::InvalidArgument, "turns"));
  ConsistentMatting matting = matting_for(stage.rig());
  EXPECT_THAT(matting.matte(std::vector<Image>(8)), FailsWith(ErrorCode::BadData, "fewer than two"));
  EXPECT_THAT(matting.matte(std::vector<Image>(3)), FailsWith(ErrorCode::InvalidArgument, "8 cameras"));
  std::vector<Image> small = stage.pictures;
  small[1] = Image(10, 10, 3);
  EXPECT_THAT(matting.matte(small), FailsWith(ErrorCode::InvalidArgument, "cam01"));
  EXPECT_THAT(matting.matte(stage.pictures, {}, [] { return false; }),
              FailsWith(ErrorCode::Cancelled, "stopped"));
}

}  // namespace
}  // namespace floatstage::pipeline
