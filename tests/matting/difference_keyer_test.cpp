#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "matting/keyers/keyer.h"
#include "tests/matting/pictures.h"

namespace floatstage::matting {
namespace {

Image shaded(Image image, double factor) {
  for (int y = 40; y < 80; ++y)
    for (int x = 40 * 3; x < 120 * 3; ++x)
      image.pixels[image.offset(0, y) + static_cast<std::size_t>(x)] =
          static_cast<std::uint8_t>(image.pixels[image.offset(0, y) + static_cast<std::size_t>(x)] * factor);
  return image;
}

double coverage_of(const Image& plate, const Image& picture) {
  auto keyer = make_keyer("difference", {plate});
  EXPECT_TRUE(keyer);
  return coverage(*(*keyer)->key(make_frame({}, picture)));
}

TEST(DifferenceKeyer, TakesAShadowOfTheSubjectForThePlate) {
  const Image plate = empty_stage({});
  EXPECT_EQ(coverage_of(plate, shaded(plate, 0.65)), 0);
  EXPECT_EQ(coverage_of(plate, shaded(plate, 1.1)), 0);
}

TEST(DifferenceKeyer, SeesABlackSubjectThatNoShadowExplains) {
  const Image plate = empty_stage({});
  EXPECT_NEAR(coverage_of(plate, shaded(plate, 0.1)), 80 * 40 / (160.0 * 120), 0.005);
}

TEST(DifferenceKeyer, SeesAChangeOfColourOfTheSameBrightness) {
  Scene scene;
  scene.vignette = 0;
  scene.subject = {105, 88, 58};  // the backing's luma, another hue
  auto keyer = make_keyer("difference", {empty_stage(scene)});
  ASSERT_TRUE(keyer);
  EXPECT_GE(iou(*(*keyer)->key(make_frame({}, photograph(scene))), truth(scene)), 0.97);
}

TEST(DifferenceKeyer, MakesAPlateOfPhotographsInWhichTheSubjectMoves) {
  const Scene scene;
  std::vector<Image> photographs;
  for (int shift : {-45, -15, 15, 45, 60}) {  // no pixel is covered in more than two of the five
    Image image = empty_stage(scene);
    for (int y = 45; y < 75; ++y)
      for (int x = 80 + shift - 14; x < 80 + shift + 14; ++x) image.at(x, y)[0] = 220;
    photographs.push_back(image);
  }
  auto keyer = make_keyer("difference", photographs);
  ASSERT_TRUE(keyer);
  EXPECT_GE(iou(*(*keyer)->key(make_frame({}, photograph(scene))), truth(scene)), 0.97);
}

TEST(DifferenceKeyer, RefusesAFrameOfAnotherSizeThanThePlate) {
  auto keyer = make_keyer("difference", {empty_stage({})});
  ASSERT_TRUE(keyer);
  FrameInfo info;
  info.camera = 6;
  const auto matte = (*keyer)->key(make_frame(info, Image(80, 60, 3)));
  ASSERT_FALSE(matte);
  EXPECT_EQ(matte.error().code, ErrorCode::InvalidArgument);
  EXPECT_THAT(matte.error().message,
              ::testing::AllOf(::testing::HasSubstr("camera 6"), ::testing::HasSubstr("80x60"),
                               ::testing::HasSubstr("160x120")));
}

TEST(DifferenceKeyer, RefusesToStartWithoutAPlateOrWithUnequalOnes) {
  EXPECT_EQ(make_keyer("difference", {}).error().code, ErrorCode::InvalidArgument);
  EXPECT_EQ(make_keyer("difference", {Image(4, 4, 3), Image(4, 5, 3)}).error().code,
            ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace floatstage::matting
