#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "matting/keyers/backing.h"
#include "matting/keyers/keyer.h"
#include "tests/matting/pictures.h"

namespace floatstage::matting {
namespace {

Matte keyed(const Scene& scene, const char* spec = "chroma") {
  auto keyer = make_keyer(spec, {photograph(scene, 7)});
  EXPECT_TRUE(keyer) << keyer.error().message;
  auto matte = (*keyer)->key(make_frame({}, photograph(scene)));
  EXPECT_TRUE(matte);
  return *matte;
}

TEST(ChromaKeyer, NeedsNoPlateWhenTheBordersShowTheCloth) { EXPECT_GE(iou(keyed({}), truth({})), 0.97); }

TEST(ChromaKeyer, KeysABlueClothAsWell) {
  Scene scene;
  scene.backing = {30, 60, 150};
  EXPECT_GE(iou(keyed(scene), truth(scene)), 0.97);
}

TEST(ChromaKeyer, KeepsBlackHairBeforeDarkCloth) {
  Scene scene;
  scene.backing = {14, 40, 20};
  scene.subject = {12, 11, 12};
  scene.vignette = 0;
  scene.noise = 0.7;
  EXPECT_GE(iou(keyed(scene), truth(scene)), 0.93);
}

TEST(ChromaKeyer, TakesClothInDeepShadowForCloth) {
  Scene scene;
  scene.vignette = 0.9;  // a tenth of the light in the corners
  EXPECT_GE(iou(keyed(scene), truth(scene)), 0.97);
}

TEST(ChromaKeyer, KeepsASubjectWithGreenSpill) {
  Scene scene;
  scene.subject = {120, 132, 110};  // a grey coat in the light of the cloth
  EXPECT_GE(iou(keyed(scene), truth(scene)), 0.97);
}

TEST(ChromaKeyer, GivesTheClothsShareOfAMixedPixelToTheBackground) {
  const Matte matte = keyed({.vignette = 0});
  // The disc's border pixels: opacity grows with coverage.
  int checked = 0;
  for (int x = 40; x < 60; ++x) {
    const double covered = disc_coverage({}, x, 60);
    const int alpha = matte.row(60)[x];
    if (covered <= 0) {
      EXPECT_EQ(alpha, 0) << x;
    } else if (covered >= 1) {
      EXPECT_EQ(alpha, 255) << x;
    }
    EXPECT_GE(alpha, matte.row(60)[x - 1]) << x;
    ++checked;
  }
  EXPECT_EQ(checked, 20);
}

TEST(ChromaKeyer, LimitsTheBackingsChannelToTheLargerOfTheOthers) {
  const auto green = make_keyer("chroma:#28783c", {}), blue = make_keyer("chroma:#1e3c96", {});
  ASSERT_TRUE(green && blue);
  Image image(3, 1, 3);
  image.pixels = {100, 130, 90, 200, 150, 120, 90, 100, 130};
  EXPECT_EQ((*green)->suppress_spill(make_frame({}, image))->pixels,
            (std::vector<std::uint8_t>{100, 100, 90, 200, 150, 120, 90, 100, 130}));
  EXPECT_EQ((*blue)->suppress_spill(make_frame({}, image))->pixels,
            (std::vector<std::uint8_t>{100, 130, 90, 200, 150, 120, 90, 100, 100}));
}

TEST(ChromaKeyer, RefusesGreyFramesAndGreyClothAndNamesAnotherKeyer) {
  auto keyer = make_keyer("chroma:#28783c", {});
  ASSERT_TRUE(keyer);
  const auto matte = (*keyer)->key(make_frame({}, Image(8, 8, 1)));
  ASSERT_FALSE(matte);
  EXPECT_EQ(matte.error().code, ErrorCode::Unsupported);
  EXPECT_THAT(matte.error().message, ::testing::HasSubstr("luminance"));
  EXPECT_EQ(make_keyer("chroma:#808080", {}).error().code, ErrorCode::InvalidArgument);
}

TEST(ChromaKeyer, SaysWhenNoPictureShowsCloth) {
  EXPECT_EQ(make_keyer("chroma", {}).error().code, ErrorCode::InvalidArgument);
  const auto made = make_keyer("chroma", {Image(64, 48, 3, 100)});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::NotFound);
  EXPECT_THAT(made.error().message, ::testing::HasSubstr("#rrggbb"));
}

TEST(SampleBacking, FindsTheClothNotTheLargerGreyWall) {
  Image image(100, 100, 3, 130);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 30; ++x) {
      image.at(x, y)[0] = 40;
      image.at(x, y)[1] = static_cast<std::uint8_t>(100 + y % 5);
      image.at(x, y)[2] = 60;
    }
  const auto found = sample_backing({image});
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, (Rgb{40, 102, 60}));
}

TEST(SampleBacking, IgnoresAGreenSubjectInTheMiddle) {
  Scene scene;
  scene.backing = {60, 60, 60};
  scene.subject = {20, 200, 20};
  EXPECT_FALSE(sample_backing({photograph(scene)}));
  EXPECT_FALSE(sample_backing({}));
}

}  // namespace
}  // namespace floatstage::matting
