#include "matting/foreground.h"

#include <algorithm>
#include <cmath>

#include "tests/matting/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

TEST(Foreground, IsTheSubjectsColourEverywhereInTheSoftEdge) {
  Scene scene;
  scene.vignette = 0.3;
  const Image picture = photograph(scene), matte = to_image(truth(scene));
  const Result<Layers> layers = estimate_foreground(picture, matte);
  ASSERT_THAT(layers, IsOk());
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (*matte.at(x, y) < 40) continue;
      EXPECT_NEAR(layers->foreground.at(x, y)[0], scene.subject.r, 8) << x << " " << y;
      EXPECT_NEAR(layers->foreground.at(x, y)[1], scene.subject.g, 8) << x << " " << y;
    }
  }
}

TEST(Foreground, ComposesToThePictureAgain) {
  Scene scene;
  scene.noise = 2;
  const Image picture = photograph(scene), matte = to_image(truth(scene));
  const Result<Layers> layers = estimate_foreground(picture, matte);
  ASSERT_THAT(layers, IsOk());
  double sum = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const double a = matte.pixels[i / 3] / 255.0;
    sum += std::abs(a * layers->foreground.pixels[i] + (1 - a) * layers->background.pixels[i] -
                    picture.pixels[i]);
  }
  EXPECT_LT(sum / static_cast<double>(picture.pixels.size()), 1.0);
}

TEST(Foreground, SurvivesAMatteThatIsAllOneThing) {
  const Image picture = photograph(Scene{});
  EXPECT_EQ(estimate_foreground(picture, Image(160, 120, 1, 255))->foreground, picture);
  EXPECT_EQ(estimate_foreground(picture, Image(160, 120, 1, 0))->background, picture);
  EXPECT_THAT(estimate_foreground(Image(1, 1, 3, 7), Image(1, 1, 1, 99)), IsOk());
  EXPECT_THAT(estimate_foreground(picture, Image(10, 10, 1)), FailsWith(ErrorCode::InvalidArgument, "10x10"));
}

Image one_pixel(int r, int g, int b) {
  Image image(1, 1, 3);
  image.pixels = {static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)};
  return image;
}

Image without_spill(Image image, BackingChannel channel, double average = 0, bool keep_luma = false) {
  despill(image, channel, average, keep_luma);
  return image;
}

TEST(Despill, LimitsTheClothsChannelToTheOthers) {
  EXPECT_EQ(without_spill(one_pixel(120, 180, 90), BackingChannel::Green), one_pixel(120, 120, 90));
  EXPECT_EQ(without_spill(one_pixel(120, 90, 180), BackingChannel::Blue), one_pixel(120, 90, 120));
  EXPECT_EQ(without_spill(one_pixel(120, 180, 90), BackingChannel::Blue), one_pixel(120, 180, 90))
      << "a green shirt on blue cloth";
  EXPECT_EQ(without_spill(one_pixel(120, 180, 90), BackingChannel::Green, 1), one_pixel(120, 105, 90));
  EXPECT_EQ(without_spill(one_pixel(200, 150, 130), BackingChannel::Green), one_pixel(200, 150, 130))
      << "skin";
}

TEST(Despill, GivesTheLightBackToAllChannelsOnRequest) {
  const Image clean = without_spill(one_pixel(100, 200, 100), BackingChannel::Green, 0, true);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(clean.pixels[c], 100 + 0.587 * 100, 1);
}

}  // namespace
}  // namespace floatstage::matting
