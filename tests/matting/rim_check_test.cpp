#include "matting/keyers/rim_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "matting/keyers/keyer.h"
#include "tests/matting/pictures.h"

namespace floatstage::matting {
namespace {

FrameInfo of_camera(int camera) {
  FrameInfo info;
  info.camera = camera;
  return info;
}

TEST(RimCheck, SaysWhichCameraShowsNoBacking) {
  Image alpha(100, 80, 1, 0);
  EXPECT_TRUE(check_rim(alpha, of_camera(3), "cloth"));
  for (int y = 40; y < 80; ++y) std::fill_n(alpha.at(0, y), 100, std::uint8_t{255});
  EXPECT_TRUE(check_rim(alpha, of_camera(3), "cloth")) << "half of the rim is still a subject";
  for (int y = 35; y < 40; ++y) std::fill_n(alpha.at(0, y), 100, std::uint8_t{255});
  const Result<void> said = check_rim(alpha, of_camera(3), "cloth");
  ASSERT_FALSE(said);
  EXPECT_EQ(said.error().code, ErrorCode::Unsupported);
  EXPECT_THAT(said.error().message,
              testing::AllOf(testing::HasSubstr("camera 3"), testing::HasSubstr("cloth")));
}

TEST(RimCheck, LeavesPicturesAloneThatAreTooSmallToHaveARim) {
  EXPECT_TRUE(check_rim(Image(33, 33, 1, 255), of_camera(0), "cloth"));
}

// A carpet of cloth before a wall that is none.
TEST(ChromaKeyer, SaysSoWhereHardlyAnyOfThePictureIsCloth) {
  Image picture = photograph({.backing = {150, 140, 130}, .noise = 1});
  for (int y = 60; y < 120; ++y)
    for (int x = 60; x < 100; ++x)
      picture.at(x, y)[0] = 30, picture.at(x, y)[1] = 130, picture.at(x, y)[2] = 50;
  const auto keyer = make_keyer("chroma:#1e8232", {});
  ASSERT_TRUE(keyer);
  const auto matte = (*keyer)->key(make_frame(of_camera(5), picture));
  ASSERT_FALSE(matte);
  EXPECT_THAT(matte.error().message, testing::HasSubstr("camera 5"));
}

TEST(LuminanceKeyer, SaysSoWhereTheStageIsNotBlack) {
  const Image picture = photograph({.noise = 1});  // green cloth
  const auto keyer = make_keyer("luminance", {picture});
  ASSERT_TRUE(keyer);
  const auto matte = (*keyer)->key(make_frame(of_camera(2), picture));
  ASSERT_FALSE(matte);
  EXPECT_EQ(matte.error().code, ErrorCode::Unsupported);
  EXPECT_THAT(matte.error().message, testing::HasSubstr("camera 2"));
}

}  // namespace
}  // namespace floatstage::matting
