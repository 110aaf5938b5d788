#include "matting/labels/label_descent.h"

#include <algorithm>
#include <functional>

#include <gmock/gmock.h>

namespace floatstage::matting {
namespace {

constexpr int kWidth = 120, kHeight = 80;

// A label: a square in the picture's middle.
Image square(int left, int right) {
  Image out(kWidth, kHeight, 1);
  for (int y = 20; y < 60; ++y)
    for (int x = left; x < right; ++x) *out.at(x, y) = 1;
  return out;
}

FrameFlow flow(const std::function<float(float x)>& u) {
  FrameFlow out{kWidth, kHeight, {}};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      out.uv.push_back(u(static_cast<float>(x)));
      out.uv.push_back(0);
    }
  return out;
}

long fresh(const Image& image) {
  return std::count(image.pixels.begin(), image.pixels.end(), std::uint8_t{255});
}

TEST(LabelDescent, CallsNothingFreshOfALabelThatOnlyMoves) {
  LabelDescent descent(kWidth, kHeight);
  for (int f = 0; f < 10; ++f) descent.follow(flow([](float) { return -2.0f; }));
  EXPECT_EQ(fresh(descent.fresh(square(50, 90), 2)), 0);
}

// Flow draws two pixels at the square's right edge out to thirty.
TEST(LabelDescent, CallsFreshWhatIsDrawnOutOfALabelsEdge) {
  LabelDescent descent(kWidth, kHeight);
  for (int f = 0; f < 10; ++f)
    descent.follow(flow([f](float x) {
      const float edge = 60, grown = 3.0f * static_cast<float>(f);
      return x < edge ? 0.0f : x < edge + grown + 3 ? -(x - edge) * 3 / (grown + 3) : -3.0f;
    }));
  const Image found = descent.fresh(square(20, 88), 2);
  EXPECT_EQ(*found.at(75, 40), 255) << "the car";
  EXPECT_EQ(*found.at(40, 40), 0) << "the sleeve";
  EXPECT_EQ(*found.at(110, 40), 0) << "what is no label's is nobody's new matter";
  EXPECT_EQ(fresh(descent.fresh(square(20, 118), 2)) > 0, false) << "what lies within a label is its own";
}

TEST(LabelDescent, LetsALabelComeNearerAsAWhole) {
  LabelDescent descent(kWidth, kHeight);
  for (int f = 0; f < 10; ++f) descent.follow(flow([](float x) { return -0.15f * (x - 60); }));
  EXPECT_EQ(fresh(descent.fresh(square(40, 80), 2)), 0);
}

TEST(LabelDescent, KnowsWhatCameInOverThePicturesBorder) {
  LabelDescent descent(kWidth, kHeight);
  for (int f = 0; f < 10; ++f) descent.follow(flow([](float) { return 4.0f; }));
  EXPECT_EQ(fresh(descent.fresh(square(60, 120), 2)), 0);
}

TEST(LabelDescent, AsksOnlyTheLastFrames) {
  LabelDescent descent(kWidth, kHeight);
  for (int f = 0; f < 10; ++f) descent.follow(flow([](float x) { return x < 60 ? 0.0f : -0.5f * (x - 60); }));
  ASSERT_GT(fresh(descent.fresh(square(20, 90), 2)), 0);
  for (int f = 0; f < 48; ++f) descent.follow(flow([](float) { return 0.0f; }));
  EXPECT_EQ(fresh(descent.fresh(square(20, 90), 2)), 0);
}

}  // namespace
}  // namespace floatstage::matting
