#include "detail/harmonic_fill.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::detail {
namespace {

using Mask = std::vector<std::uint8_t>;

// Gauss and Seidel until nothing moves: slow, and beyond doubt.
LightPicture relaxed(LightPicture p, const Mask& fixed) {
  for (std::size_t i = 0; i < fixed.size(); ++i)
    if (fixed[i] == 0) p.pixels[i] = {};
  for (int round = 0; round < 20000; ++round)
    for (int y = 0; y < p.height; ++y)
      for (int x = 0; x < p.width; ++x) {
        if (fixed[p.index(x, y)] != 0) continue;
        const Light &l = p.at(std::max(x - 1, 0), y), &r = p.at(std::min(x + 1, p.width - 1), y),
                    &a = p.at(x, std::max(y - 1, 0)), &b = p.at(x, std::min(y + 1, p.height - 1));
        for (std::size_t k = 0; k < 4; ++k) p.at(x, y)[k] = (l[k] + r[k] + a[k] + b[k]) / 4;
      }
  return p;
}

void expect_near(const LightPicture& a, const LightPicture& b, double most) {
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) ASSERT_NEAR(a.pixels[i][k], b.pixels[i][k], most) << i;
}

LightPicture noise(int width, int height, Random& random) {
  LightPicture p(width, height);
  for (Light& light : p.pixels)
    for (float& v : light) v = static_cast<float>(random.uniform());
  return p;
}

TEST(HarmonicFill, IsThatOfRelaxationForAnyPixelsThatAreKnown) {
  Random random(3);
  for (const double known : {0.002, 0.02, 0.3})
    for (const auto& [w, h] : {std::pair(37, 22), {64, 48}}) {
      LightPicture p = noise(w, h, random);
      Mask fixed(p.pixels.size());
      for (auto& f : fixed) f = random.uniform() < known ? 1 : 0;
      fixed[7] = 1;
      const LightPicture truth = relaxed(p, fixed);
      EXPECT_LT(fill_harmonically(p, fixed, 1e-5F), 30) << known;
      expect_near(p, truth, 5e-4);
    }
}

TEST(HarmonicFill, InsideAFrameWhereverItLiesTakesFewCycles) {
  for (const int margin : {1, 2, 3, 4, 8, 15, 16, 17}) {
    Random random(static_cast<std::uint64_t>(margin));
    LightPicture p = noise(160, 128, random);
    Mask fixed(p.pixels.size(), 1);
    for (int y = margin; y < 128 - margin; ++y)
      std::fill_n(fixed.begin() + static_cast<std::ptrdiff_t>(p.index(margin, y)), 160 - 2 * margin, 0);
    EXPECT_LE(fill_harmonically(p, fixed), 12) << margin;
  }
}

TEST(HarmonicFill, ContinuesAPlaneExactly) {
  LightPicture p(50, 40);
  Mask fixed(p.pixels.size(), 0);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x) {
      p.at(x, y) = {0.01F * static_cast<float>(x), 0.02F * static_cast<float>(y), 1, -1};
      fixed[p.index(x, y)] = x == 0 || y == 0 || x == 49 || y == 39 ? 1 : 0;
    }
  const LightPicture plane = p;
  fill_harmonically(p, fixed, 1e-6F);
  expect_near(p, plane, 1e-4);
}

TEST(HarmonicFill, WithNothingKnownIsZeroAndWithAllKnownTouchesNothing) {
  Random random(1);
  LightPicture p = noise(9, 5, random);
  const LightPicture before = p;
  fill_harmonically(p, Mask(45, 1));
  EXPECT_EQ(p.pixels, before.pixels);
  EXPECT_EQ(fill_harmonically(p, Mask(45, 0)), 0);
  EXPECT_EQ(p.pixels, LightPicture(9, 5).pixels);
  LightPicture one(1, 1);
  fill_harmonically(one, Mask(1, 0));
}

}  // namespace
}  // namespace floatstage::detail
