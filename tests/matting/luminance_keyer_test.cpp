#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "matting/keyers/keyer.h"
#include "tests/matting/pictures.h"

namespace floatstage::matting {
namespace {

constexpr CleanupOptions kNone{.smallest_island = 0, .smallest_hole = 0};

TEST(LuminanceKeyer, TakesExactlyTheGreysAboveTheThresholdForSubject) {
  for (int threshold : {1, 12, 13, 200, 254}) {
    auto keyer = make_keyer("luminance:" + std::to_string(threshold), {}, kNone);
    ASSERT_TRUE(keyer);
    for (int grey = 0; grey < 256; ++grey) {
      Image image(9, 9, 1);  // a square that keeps clear of the border
      for (int y = 2; y < 7; ++y) std::fill_n(image.at(2, y), 5, static_cast<std::uint8_t>(grey));
      const auto matte = (*keyer)->key(make_frame({}, image));
      ASSERT_TRUE(matte);
      EXPECT_EQ(*to_image(*matte).at(4, 4) >= 128, grey > threshold) << grey << " at " << threshold;
    }
  }
}

TEST(LuminanceKeyer, WeighsColoursAsLuma) {
  auto keyer = make_keyer("luminance:100", {}, kNone);
  ASSERT_TRUE(keyer);
  Image image(3, 1, 3);
  image.pixels = {255, 0, 0, 0, 255, 0, 0, 0, 255};  // luma 76, 150, 29
  const Image alpha = to_image(*(*keyer)->key(make_frame({}, image)));
  EXPECT_LT(alpha.pixels[0], 128);
  EXPECT_GE(alpha.pixels[1], 128);
  EXPECT_LT(alpha.pixels[2], 128);
}

TEST(LuminanceKeyer, ByDefaultClosesCrevicesAndDropsSpecks) {
  Image image(100, 100, 3, 2);
  for (int y = 20; y < 80; ++y)
    for (int x = 20; x < 80; ++x)
      if (y < 48 || y > 51) std::fill_n(image.at(x, y), 3, std::uint8_t{120});
  std::fill_n(image.at(5, 5), 15, std::uint8_t{120});
  const auto matte = (*make_keyer("luminance", {}))->key(make_frame({}, image));
  ASSERT_TRUE(matte);
  // The crevice's two ends lie on the outline, where it is solved: up to the closing's radius and a pixel of
  // band, three columns of four rows each are the stage's.
  EXPECT_NEAR(coverage(*matte), 0.36, 2 * 3 * 4 / 10000.0 + 1e-9);
}

TEST(LuminanceKeyer, TakesLitClothAtTheBorderForBackgroundButNotADarkCoat) {
  Image image(100, 100, 3, 2);
  for (int y = 70; y < 100; ++y) std::fill_n(image.at(0, y), 300, std::uint8_t{30});  // the floor cloth
  for (int y = 10; y < 60; ++y) std::fill_n(image.at(35, y), 90, std::uint8_t{30});   // a dark coat
  for (int y = 60; y < 90; ++y) std::fill_n(image.at(35, y), 90, std::uint8_t{140});  // and bright boots
  const Image alpha = to_image(*(*make_keyer("luminance", {}))->key(make_frame({}, image)));
  EXPECT_EQ(*alpha.at(5, 95), 0);
  EXPECT_EQ(*alpha.at(20, 80), 0);
  EXPECT_EQ(*alpha.at(50, 30), 255);
  EXPECT_EQ(*alpha.at(50, 80), 255);
}

TEST(LuminanceKeyer, RefusesBlackWallsAboveALitGreenFloor) {
  Image image(200, 200, 3, 4);
  for (int y = 120; y < 200; ++y)
    for (int x = 0; x < 200; ++x) {
      std::uint8_t* p = image.at(x, y);
      p[0] = 40, p[1] = static_cast<std::uint8_t>(150 + 20 * std::sin(x * 0.09)), p[2] = 60;
    }
  for (int y = 40; y < 170; ++y) std::fill_n(image.at(80, y), 3 * 40, std::uint8_t{140});  // a person
  const auto keyer = make_keyer("luminance", {image});
  ASSERT_TRUE(keyer);
  FrameInfo info;
  info.camera = 2;
  const auto matte = (*keyer)->key(make_frame(info, image));
  ASSERT_FALSE(matte);
  EXPECT_THAT(matte.error().message,
              testing::HasSubstr("camera 2 shows no black stage: green or blue cloth"));
  EXPECT_THAT(matte.error().message, testing::HasSubstr("'chroma'"));
}

TEST(LuminanceKeyer, LeavesAGreenCoatOnABlackStageAlone) {
  Image image(200, 200, 3, 4);
  for (int y = 40; y < 170; ++y)
    for (int x = 80; x < 120; ++x) image.at(x, y)[0] = 40, image.at(x, y)[1] = 150, image.at(x, y)[2] = 60;
  const auto matte = (*make_keyer("luminance", {image}))->key(make_frame({}, image));
  ASSERT_TRUE(matte) << matte.error().message;
  EXPECT_NEAR(coverage(*matte), 40 * 130 / 40000.0, 0.01);
}

}  // namespace
}  // namespace floatstage::matting
