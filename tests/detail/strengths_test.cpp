// How strong borrowed details are made (docs/adr/0309).

#include "detail/synthesis/strengths.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::detail {
namespace {

constexpr int kSide = 512, kLevels = 4, kZoom = 16;

// Noise of one strength at the left and of eight times that at the right, in blocks of 16 px and in pixels.
Image weak_and_strong() {
  Random random(3);
  Image out(kSide, kSide, 3);
  std::array<double, (kSide / kZoom) * (kSide / kZoom)> blocks{};
  for (double& b : blocks) b = random.uniform(-1, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double strength = x < kSide / 2 ? 4 : 32;
      const double block = blocks[static_cast<std::size_t>(y / kZoom * (kSide / kZoom) + x / kZoom)];
      const auto grey = static_cast<std::uint8_t>(128 + strength * (block + random.uniform(-1, 1)));
      std::fill_n(out.at(x, y), 3, grey);
    }
  return out;
}

struct Scene {
  ColorGrid root;
  std::vector<LayerPyramid> layers;
};

// The picture's root, and a close photograph of `side` px in its middle.
Scene scene_of(int side) {
  const Image truth = weak_and_strong();
  const int at = (kSide - side) / 2;
  DetailLayer layer{Image(side, side, 4, 255), at, at, kLevels, false};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) std::copy_n(truth.at(at + x, at + y), 3, layer.picture.at(x, y));
  ColorGrid root = to_colors(truth);
  for (int t = 0; t < kLevels; ++t) root = halved(root);
  return {root, {LayerPyramid(layer, kLevels)}};
}

Exemplars exemplars_of(const Scene& scene) { return {scene.layers, kLevels, 1'000'000, 1}; }

TEST(Strengths, AreThoseOfPlacesThatLookLikeThisOne) {
  const Scene scene = scene_of(320);
  const Exemplars exemplars = exemplars_of(scene);
  const Strengths strengths(scene.root, scene.layers, exemplars, kLevels);
  const auto weak = exemplars.place_of(0, kLevels, 150, 256),
             strong = exemplars.place_of(0, kLevels, 360, 256);
  ASSERT_NE(weak, Exemplars::kNowhere);
  ASSERT_NE(strong, Exemplars::kNowhere);
  const int cells = kSide / 2;
  for (std::size_t part = 0; part < Strengths::kParts; ++part) {
    EXPECT_LT(strengths.gains(kLevels, cells / 8, cells / 2, strong)[part], 0.9F) << "calm at the left";
    EXPECT_GT(strengths.gains(kLevels, cells * 7 / 8, cells / 2, weak)[part], 1.1F) << "strong at the right";
    EXPECT_NEAR(strengths.gains(kLevels, cells / 8, cells / 8, weak)[part], 1, 0.25F);
    EXPECT_NEAR(strengths.gains(kLevels, cells * 7 / 8, cells / 8, strong)[part], 1, 0.25F);
    EXPECT_GE(strengths.gains(kLevels, 0, 0, strong)[part], 0.49F) << "within bounds";
  }
}

TEST(Strengths, AreLeftAsTheyAreWhereTooLittleIsShown) {
  const Scene scene = scene_of(160);  // 100 pixels of the root
  const Exemplars exemplars = exemplars_of(scene);
  const Strengths strengths(scene.root, scene.layers, exemplars, kLevels);
  const Strengths::Gains gains = strengths.gains(kLevels, 10, 10, exemplars.place_of(0, kLevels, 300, 256));
  EXPECT_EQ(gains, (Strengths::Gains{1, 1, 1}));
  EXPECT_EQ(strengths.gains(kLevels, 10, 10, Exemplars::kNowhere), (Strengths::Gains{1, 1, 1}));
}

}  // namespace
}  // namespace floatstage::detail
