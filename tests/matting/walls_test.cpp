#include "matting/keyers/walls.h"

#include <gtest/gtest.h>

#include "matting/keyers/keyer.h"
#include "tests/matting/pictures.h"

namespace floatstage::matting {
namespace {

constexpr int kWidth = 320, kHeight = 240, kFloor = 110;

// A green floor below a dark wall with lamps, both noisy; and somebody in red, between `top` and `bottom`.
struct Dome {
  int left = 130, right = 190, top = 60, bottom = 200;
  bool wall = true;
  std::uint64_t seed = 1;

  Image photograph() const {
    Random random(seed);
    Image picture(kWidth, kHeight, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const bool lamp = y % 40 >= 18 && y % 40 < 22 && x % 50 >= 23 && x % 50 < 27;
        const double light = 0.8 + 0.2 * y / kHeight;
        std::array<double, 3> c = {40 * light, 120 * light, 60 * light};
        if (y < kFloor && wall) c = lamp ? std::array{150.0, 145.0, 130.0} : std::array{12.0, 13.0, 14.0};
        if (subject(x, y)) c = {190, 50, 45};
        for (int k = 0; k < 3; ++k)
          picture.at(x, y)[k] = static_cast<std::uint8_t>(
              std::clamp(std::lround(c[static_cast<std::size_t>(k)] + 1.5 * random.normal()), 0L, 255L));
      }
    return picture;
  }
  bool subject(int x, int y) const { return x >= left && x < right && y >= top && y < bottom; }
  Matte truth() const {
    Image alpha(kWidth, kHeight, 1);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) *alpha.at(x, y) = subject(x, y) ? 255 : 0;
    return make_matte({}, alpha);
  }
};

double agreement(const Dome& dome) {
  const Image picture = dome.photograph();
  const auto keyer = make_keyer("chroma", {picture});
  EXPECT_TRUE(keyer);
  const auto matte = (*keyer)->key(make_frame({}, picture));
  EXPECT_TRUE(matte) << matte.error().message;
  return matte ? iou(*matte, dome.truth()) : 0;
}

TEST(ChromaKeyerBeforeAWall, LearnsItAndItsLampsFromOnePicture) { EXPECT_GE(agreement({}), 0.96); }

TEST(ChromaKeyerBeforeAWall, KeepsASubjectWhomTheFrameCutsOff) {
  EXPECT_GE(agreement({.bottom = kHeight}), 0.95) << "with a wall";
  EXPECT_GE(agreement({.left = 60, .right = 260, .bottom = kHeight, .wall = false}), 0.96)
      << "two thirds of the lower side are no wall";
}

TEST(Walls, AreNotLearntFromASubjectAtTheFrame) {
  const Dome cut{.left = 60, .right = 260, .bottom = kHeight, .wall = false};
  Image cloth = to_image(cut.truth());
  EXPECT_FALSE(Walls::learn({cut.photograph()}, {cloth}));
  for (int y = 0; y < kFloor; ++y) std::fill_n(cloth.at(0, y), kWidth, std::uint8_t{255});
  Dome walled = cut;
  walled.wall = true;
  EXPECT_TRUE(Walls::learn({walled.photograph()}, {cloth}));
}

}  // namespace
}  // namespace floatstage::matting
