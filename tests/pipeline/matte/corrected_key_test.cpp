#include "pipeline/matte/corrected_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

constexpr int kSide = 120, kCutSide = 40;  // a pixel of the cut is three of the picture's

struct Box {
  int left, top, right, bottom;  // the last two not included
};

void fill(Image& mask, const Box& box, std::uint8_t value) {
  for (int y = box.top; y < box.bottom; ++y)
    for (int x = box.left; x < box.right; ++x) *mask.at(x, y) = value;
}

// A bright square before a dark wall, as a picture, as a key's matte and as a cut.
const Box kSubject = {30, 30, 90, 90};

Image picture() {
  Image shown(kSide, kSide, 3, 20);
  for (int y = kSubject.top; y < kSubject.bottom; ++y)
    for (int x = kSubject.left; x < kSubject.right; ++x)
      for (int c = 0; c < 3; ++c) shown.at(x, y)[c] = 200;
  return shown;
}

Image key() {
  Image mask(kSide, kSide, 1);
  fill(mask, kSubject, 255);
  return mask;
}

Image cut() {
  Image mask(kCutSide, kCutSide, 1);
  fill(mask, {10, 10, 30, 30}, 255);
  return mask;
}

TEST(CorrectedKey, IsTheKeyWhereTheCutSaysTheSame) {
  const Result<Image> corrected = corrected_key(picture(), key(), cut());
  ASSERT_THAT(corrected, IsOk());
  EXPECT_EQ(corrected->pixels, key().pixels);
}

TEST(CorrectedKey, FillsAThickHole) {
  Image holed = key();
  fill(holed, {51, 51, 69, 69}, 0);
  const Result<Image> corrected = corrected_key(picture(), holed, cut());
  ASSERT_THAT(corrected, IsOk());
  EXPECT_EQ(*corrected->at(60, 60), 255);
  EXPECT_EQ(*corrected->at(35, 60), 255);
  EXPECT_EQ(*corrected->at(10, 10), 0);
}

TEST(CorrectedKey, TakesAwayAThickIsland) {
  Image more = key();
  fill(more, {96, 96, 117, 117}, 255);
  const Result<Image> corrected = corrected_key(picture(), more, cut());
  ASSERT_THAT(corrected, IsOk());
  EXPECT_EQ(*corrected->at(106, 106), 0);
  EXPECT_EQ(*corrected->at(60, 60), 255);
}

// Of strands, fingers and the gaps between them a key knows more than a cut of fewer pixels.
TEST(CorrectedKey, KeepsWhatIsThin) {
  Image thin = key();
  fill(thin, {90, 57, 115, 63}, 255);
  fill(thin, {54, 30, 60, 45}, 0);
  const Result<Image> corrected = corrected_key(picture(), thin, cut());
  ASSERT_THAT(corrected, IsOk());
  EXPECT_EQ(corrected->pixels, thin.pixels);
}

// Stripes in the cloth's colour are thin, too, but they are many.
TEST(CorrectedKey, FillsThePatternOfAKeyThatLacksATwentieth) {
  Image striped = key();
  for (int y = 36; y < 84; y += 12) fill(striped, {33, y, 87, y + 3}, 0);
  const Result<Image> corrected = corrected_key(picture(), striped, cut());
  ASSERT_THAT(corrected, IsOk());
  for (int y = 36; y < 84; ++y) EXPECT_GE(*corrected->at(60, y), 250) << y;
}

TEST(CorrectedKey, RefusesWhatDoesNotFit) {
  EXPECT_THAT(corrected_key(picture(), Image(10, 10, 1), cut()),
              FailsWith(ErrorCode::InvalidArgument, "no larger"));
  EXPECT_THAT(corrected_key(picture(), key(), Image()), FailsWith(ErrorCode::InvalidArgument, "no larger"));
  EXPECT_THAT(corrected_key(picture(), key(), Image(kSide + 1, kSide, 1)),
              FailsWith(ErrorCode::InvalidArgument, "no larger"));
  EXPECT_THAT(corrected_key(key(), key(), cut()), FailsWith(ErrorCode::InvalidArgument, "no larger"));
}

}  // namespace
}  // namespace floatstage::pipeline
