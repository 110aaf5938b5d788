#include "matting/video/frame_flow.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "matting/video/matte_propagation.h"
#include "tests/matting/small_scenes.h"

namespace floatstage::matting {
namespace {

// A smooth random texture moved to the right by `shift`.
Image texture(int width, int height, double shift) {
  Image out(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double u = x - shift;
        out.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(127 + 50 * std::sin(0.31 * u + 0.2 * y + c) +
                                                                40 * std::sin(0.17 * y - 0.23 * u) +
                                                                25 * std::cos(0.6 * y)));
      }
  return out;
}

TEST(FlowBetween, FollowsATextureThatMoves) {
  const Image before = texture(96, 64, 0), after = texture(96, 64, 3);
  const FrameFlow flow = flow_between(before, after);
  double error = 0, count = 0;
  for (int y = 16; y < 48; ++y)
    for (int x = 16; x < 80; ++x, ++count)
      error += std::hypot(flow.uv[2 * (y * 96 + x)] + 3, flow.uv[2 * (y * 96 + x) + 1]);
  EXPECT_LT(error / count, 0.3) << "a pixel was 3 px to the left before";
}

TEST(FlowBetween, CarriesTheMatteWithThePicture) {
  const DiscPicture before = disc_picture(120, 80, 0, 0), after = disc_picture(120, 80, 4, 0);
  const MatteConstraint guidance = guidance_from(before.alpha, before.rgb, after.rgb);
  EXPECT_LT(mean_square(guidance.opacity, after.alpha), 0.3 * mean_square(before.alpha, after.alpha));
}

TEST(FlowBetween, GivesTheSameBytesAgain) {
  const Image before = texture(70, 50, 0), after = texture(70, 50, 2);
  EXPECT_EQ(flow_between(before, after).uv, flow_between(before, after).uv);
}

TEST(FlowBetween, FindsNoneInPicturesSmallerThanItsPatches) {
  const FrameFlow flow = flow_between(texture(5, 4, 0), texture(5, 4, 0));
  for (const float value : flow.uv) EXPECT_EQ(value, 0);
}

TEST(ConfidenceOf, IsLowWhereThePictureIsNotExplained) {
  const Image before = texture(64, 48, 0);
  Image after = before;
  for (int y = 10; y < 20; ++y)
    for (int x = 10; x < 20; ++x)
      for (int c = 0; c < 3; ++c) after.at(x, y)[c] = 255;
  const FrameFlow still{64, 48, std::vector<float>(2 * 64 * 48)};
  const Image confidence = confidence_of(before, after, still);
  EXPECT_EQ(*confidence.at(40, 30), 255);
  EXPECT_LT(*confidence.at(15, 15), 60);
}

TEST(Filtered, SmoothsShimmerAndLeavesMotion) {
  Image matte(4, 1, 1), previous(4, 1, 1);
  matte.pixels = {100, 100, 100, 0};
  previous.pixels = {110, 250, 110, 0};
  const MatteConstraint carried{previous, [] {
                                  Image w(4, 1, 1, 255);
                                  w.pixels[2] = 0;
                                  return w;
                                }()};
  const Image out = filtered(matte, carried, 0.5);
  EXPECT_GT(out.pixels[0], 100);
  EXPECT_LT(out.pixels[0], 110);
  EXPECT_EQ(out.pixels[1], 100) << "a large difference is motion";
  EXPECT_EQ(out.pixels[2], 100) << "the carried matte is not trusted there";
  EXPECT_EQ(out.pixels[3], 0);
  EXPECT_NEAR(flicker_between(matte, previous), (10 + 150 + 10) / (4 * 255.0), 1e-9);
}

}  // namespace
}  // namespace floatstage::matting
