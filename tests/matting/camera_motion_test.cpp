#include "matting/camera_motion.h"

#include <gtest/gtest.h>

#include "tests/support/matte_clips.h"

namespace floatstage::matting {
namespace {

// What a camera sees that has moved by so many pixels: a window of a larger place.
Image window(const Image& place, int x, int y, int width, int height) {
  Image out(width, height, 3);
  for (int v = 0; v < height; ++v)
    std::copy_n(place.at(x, y + v), static_cast<std::size_t>(3 * width), out.at(0, v));
  return out;
}

MatteClip dancer_before(const Image& backdrop, std::uint64_t seed) {
  return make_clip(studio_cutout(seed), backdrop,
                   {.width = backdrop.width, .height = backdrop.height, .frames = 6, .seed = seed});
}

class CameraMotion : public testing::TestWithParam<std::uint64_t> {};

TEST_P(CameraMotion, IsNoneWhileADancerCrossesAClutteredPlace) {
  const MatteClip clip = dancer_before(cluttered_place(360, 240, GetParam()), GetParam());
  for (std::size_t f = 1; f < clip.frames.size(); ++f) {
    const CameraStillness seen = stillness_between(clip.frames[0], clip.frames[f]);
    EXPECT_TRUE(seen.tells()) << seen.textured << " cells";
    EXPECT_FALSE(seen.camera_moved()) << "frame " << f << ": " << seen.still << " of " << seen.textured;
    EXPECT_GE(2 * seen.still, seen.textured) << "not even nearly";
  }
}

TEST_P(CameraMotion, IsSeenFromTwoPixelsOn) {
  const Image place = cluttered_place(420, 300, GetParam());
  const Image from = dancer_before(window(place, 30, 30, 360, 240), GetParam()).frames[0];
  for (const auto& [dx, dy] : {std::pair{2, 0}, {0, 2}, {-3, 2}, {8, -5}, {20, 12}}) {
    const Image to = dancer_before(window(place, 30 + dx, 30 + dy, 360, 240), GetParam()).frames[3];
    const CameraStillness seen = stillness_between(from, to);
    EXPECT_TRUE(seen.camera_moved()) << dx << "," << dy << ": " << seen.still << " still, " << seen.elsewhere
                                     << " elsewhere of " << seen.textured;
    EXPECT_NEAR(seen.moved, std::hypot(dx, dy), 0.5 + 0.1 * std::hypot(dx, dy));
  }
}

TEST_P(CameraMotion, IsNothingThatPlainClothTells) {
  const Image grey(360, 240, 3, 90);
  const MatteClip clip = dancer_before(grey, GetParam());
  const CameraStillness seen = stillness_between(clip.frames[0], clip.frames[5]);
  EXPECT_FALSE(seen.tells()) << "only the dancer has corners";
  EXPECT_FALSE(seen.camera_moved());
}

INSTANTIATE_TEST_SUITE_P(Seeds, CameraMotion, testing::Values(1, 2, 3, 4, 5));

TEST(CameraMotionInThePicture, IsNotALightThatGoesOut) {
  const Image place = cluttered_place(360, 240, 1), dark(360, 240, 3, 4);
  EXPECT_FALSE(stillness_between(place, dark).camera_moved());
  EXPECT_FALSE(stillness_between(dark, place).camera_moved());
  EXPECT_FALSE(stillness_between(Image(8, 8, 3, 50), Image(8, 8, 3, 60)).tells());
}

}  // namespace
}  // namespace floatstage::matting
