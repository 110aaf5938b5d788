#include "matting/still_backdrop.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

// A grey stage with noise of a step, and what stands before it in a part.
constexpr int kWidth = 240, kHeight = 180;
Image grey(double stage, double clothes, unsigned seed) {
  Random random(seed);
  Image picture(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) {
        const double light = x >= 100 && x < 140 && y >= 60 && y < 120 ? clothes : stage;
        *(picture.at(x, y) + c) = static_cast<std::uint8_t>(std::lround(light + random.normal()));
      }
  return picture;
}
const std::size_t kAmidClothes = 90 * kWidth + 120, kBeside = 90 * kWidth + 160;

TEST(StillBackdrop, WhatMovesIsLikelierSubjectAndWhatNeverMovedOnlyALittleLess) {
  std::vector<Image> clip(8, Image(3, 1, 3, 100));
  for (int c = 0; c < 3; ++c) clip[2].pixels[static_cast<std::size_t>(c)] = 200;  // somebody passed once
  const Result<StillBackdrop> backdrop = StillBackdrop::learn(clip);
  ASSERT_THAT(backdrop, IsOk());
  Image now(3, 1, 3, 100);
  for (int c = 6; c < 9; ++c) now.pixels[static_cast<std::size_t>(c)] = 30;
  const std::vector<float> odds = backdrop->odds(now);
  EXPECT_LT(odds[0], odds[1]);  // known backdrop …
  EXPECT_LT(odds[1], 0);        // … somebody might have stood there all the time …
  EXPECT_GT(odds[2], 2);        // … and something is there now
}

// Somebody stood on the first place in six of eight pictures, and on the second in all of them.
TEST(StillBackdrop, IsLearntFromWhatTheSubjectLeavesFree) {
  std::vector<Image> clip(8, Image(2, 1, 3, 20)), subjects(8, Image(2, 1, 1, 255));
  for (const std::size_t free : {2u, 5u}) {
    subjects[free].pixels[0] = 0;
    for (int c = 0; c < 3; ++c) clip[free].pixels[static_cast<std::size_t>(c)] = 100;
  }
  const Result<StillBackdrop> taken = StillBackdrop::learn(clip),
                              backdrop = StillBackdrop::learn(clip, subjects);
  ASSERT_TRUE(taken && backdrop);
  EXPECT_LT(taken->odds(clip[0])[0], 0);  // he was taken for what stands there
  EXPECT_GT(backdrop->odds(clip[0])[0], 2);
  EXPECT_LT(backdrop->odds(clip[2])[0], 0);
  EXPECT_TRUE(backdrop->knows(0));
  EXPECT_FALSE(backdrop->knows(1));
  EXPECT_EQ(backdrop->odds(clip[0])[1], 0);
}

TEST(StillBackdrop, NeedsTwoPictures) {
  EXPECT_THAT(StillBackdrop::learn(std::vector<Image>(1, Image(2, 2, 3))),
              FailsWith(ErrorCode::InvalidArgument, "two pictures"));
}

// Three quarters as bright as the stage: a shadow of it as well as trousers.
TEST(StillBackdrop, AChangeOfBrightnessTellsOnlyInConstantLight) {
  const StillBackdrop backdrop = *StillBackdrop::of_empty_stage({grey(140, 140, 1)});
  const Image now = grey(140, 105, 2);
  EXPECT_LE(backdrop.odds(now)[kAmidClothes], 0);
  const std::vector<float> constant = backdrop.odds_in_constant_light(now);
  EXPECT_GT(constant[kAmidClothes], 2);
  EXPECT_LT(constant[kBeside], -1);
}

TEST(StillBackdrop, InConstantLightAChangeThatNeighboursShareIsOne) {
  const StillBackdrop backdrop = *StillBackdrop::of_empty_stage({grey(140, 140, 1)});
  const Image now = grey(140, 136.5, 2);
  EXPECT_LT(backdrop.odds(now)[kAmidClothes], 0);
  EXPECT_GT(backdrop.odds_in_constant_light(now)[kAmidClothes], 0);
  EXPECT_LT(backdrop.odds_in_constant_light(now)[kBeside], -1);
}

TEST(StillBackdrop, LightIsNotConstantWhereAllOfTheStageHasChanged) {
  const StillBackdrop backdrop = *StillBackdrop::of_empty_stage({grey(140, 140, 1)});
  const std::vector<float> odds = backdrop.odds_in_constant_light(grey(137, 137, 2));
  EXPECT_LT(*std::max_element(odds.begin(), odds.end()), 0);
  EXPECT_TRUE(backdrop.odds_in_constant_light(grey(133, 133, 2)).empty());
}

TEST(StillBackdrop, ThatAClipTaughtKnowsNoConstantLight) {
  const StillBackdrop backdrop = *StillBackdrop::learn(std::vector<Image>(2, grey(140, 140, 1)));
  EXPECT_TRUE(backdrop.odds_in_constant_light(grey(140, 105, 2)).empty());
}

}  // namespace
}  // namespace floatstage::matting
