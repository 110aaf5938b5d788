#include "studio/live/enlarged_picture.h"

#include <gtest/gtest.h>

namespace floatstage::studio {
namespace {

Image filled(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b, std::uint8_t a) {
  Image picture(width, height, 4);
  for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
    const std::uint8_t rgba[4] = {r, g, b, a};
    std::copy_n(rgba, 4, picture.pixels.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return picture;
}

TEST(Enlarge, IsThePictureItselfAtItsOwnSize) {
  Image picture = filled(5, 3, 10, 20, 30, 255);
  picture.at(2, 1)[0] = 200;
  Image out(5, 3, 4);
  enlarge(picture, out);
  EXPECT_EQ(out, picture);
}

TEST(Enlarge, KeepsEdgesWhereTheyAre) {
  Image picture = filled(8, 4, 100, 100, 100, 0);
  for (int y = 0; y < 4; ++y)
    for (int x = 3; x < 8; ++x) picture.at(x, y)[3] = 255;
  Image out(16, 8, 4);
  enlarge(picture, out);
  EXPECT_EQ(out.at(4, 4)[3], 0);
  EXPECT_NEAR(out.at(5, 4)[3] + out.at(6, 4)[3], 255, 1) << "symmetric about the edge at column 6";
  EXPECT_EQ(out.at(7, 4)[3], 255);
}

TEST(Enlarge, MixesNoColourOfWhatIsTransparent) {
  Image picture = filled(4, 4, 0, 255, 0, 0);
  picture.at(1, 1)[0] = 200;
  picture.at(1, 1)[1] = 0;
  picture.at(1, 1)[3] = 255;
  Image out(12, 12, 4);
  enlarge(picture, out);
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x) {
      if (out.at(x, y)[3] == 0) continue;
      EXPECT_EQ(out.at(x, y)[0], 200);
      EXPECT_EQ(out.at(x, y)[1], 0);
    }
}

}  // namespace
}  // namespace floatstage::studio
