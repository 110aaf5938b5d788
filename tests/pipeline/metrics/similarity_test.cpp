#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/metrics/metrics.h"
#include "tests/pipeline/metrics/textures.h"

namespace floatstage::pipeline {
namespace {

// SSIM of one pixel as the paper writes it, by a plain loop over the window's pixels in the mask.
double ssim_at(const Image& a, const Image& b, const Image& mask, int cx, int cy) {
  double n = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
  for (int y = std::max(0, cy - 5); y <= std::min(a.height - 1, cy + 5); ++y) {
    for (int x = std::max(0, cx - 5); x <= std::min(a.width - 1, cx + 5); ++x) {
      if (*mask.at(x, y) < 128) continue;
      const double w = std::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (2 * 1.5 * 1.5)),
                   p = *a.at(x, y), q = *b.at(x, y);
      n += w, ma += w * p, mb += w * q, aa += w * p * p, bb += w * q * q, ab += w * p * q;
    }
  }
  ma /= n, mb /= n;
  const double c1 = 6.5025, c2 = 58.5225;
  return (2 * ma * mb + c1) * (2 * (ab / n - ma * mb) + c2) /
         ((ma * ma + mb * mb + c1) * (aa / n - ma * ma + bb / n - mb * mb + c2));
}

TEST(Ssim, IsTheMeanOfThePapersFormulaOverTheMask) {
  const Image a = texture(28, 24, 1), b = texture(28, 24, 2);
  for (const Image& mask : {Image(28, 24, 1, 255), box_mask(28, 24, 3, 4, 20, 15)}) {
    double sum = 0, count = 0;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 28; ++x)
        if (*mask.at(x, y) >= 128) sum += ssim_at(a, b, mask, x, y), count += 1;
    EXPECT_NEAR(ssim(a, b, mask), sum / count, 1e-9);
  }
}

TEST(Ssim, OfTwoFlatPicturesIsTheLuminanceTerm) {
  const double expected = (2 * 100 * 120 + 6.5025) / (100.0 * 100 + 120.0 * 120 + 6.5025);
  EXPECT_NEAR(ssim(Image(30, 30, 3, 100), Image(30, 30, 3, 120), Image(30, 30, 1, 255)), expected, 1e-9);
}

TEST(Ssim, OfUnrelatedTexturesIsNearZeroAndOfInvertedOnesNegative) {
  const Image mask(96, 96, 1, 255), a = texture(96, 96, 1, 1);
  EXPECT_NEAR(ssim(texture(96, 96, 2, 1), a, mask), 0, 0.1);
  EXPECT_LT(ssim(changed(a, [](double v, int, int) { return 255 - v; }), a, mask), -0.5);
}

TEST(CwSsim, OfHalfTheContrastIsFourFifths) {
  // x = y / 2 in every coefficient: 2 * (1/2) / (1 + 1/4). The truth's mean stays, so only rounding and K
  // interfere.
  const Image truth = texture(128, 96, 1, 1), mask(128, 96, 1, 255);
  const Image flat = changed(truth, [](double v, int, int) { return 127.5 + 0.5 * (v - 127.5); });
  EXPECT_NEAR(cw_ssim(flat, truth, mask), 0.8, 0.01);
}

TEST(CwSsim, ForgivesASmallShiftThatSsimPunishes) {
  const Image truth = texture(128, 96, 1, 2), moved = shifted(truth, 1, 1),
              mask = box_mask(128, 96, 8, 8, 120, 88);
  EXPECT_GT(cw_ssim(moved, truth, mask), 0.85);
  EXPECT_LT(ssim(moved, truth, mask), cw_ssim(moved, truth, mask) - 0.2);
}

TEST(CwSsim, FallsWithTheShift) {
  const Image truth = texture(128, 96, 1, 2), mask = box_mask(128, 96, 8, 8, 120, 88);
  double last = 1;
  for (int shift : {1, 2, 4, 7}) {
    const double now = cw_ssim(shifted(truth, shift, 0), truth, mask);
    EXPECT_LT(now, last) << shift;
    last = now;
  }
}

TEST(CwSsim, DoesNotForgiveAnotherTextureNoiseOrBlur) {
  const Image truth = texture(128, 96, 1, 1), mask(128, 96, 1, 255);
  const double moved = cw_ssim(shifted(truth, 1, 0), truth, mask);
  EXPECT_LT(cw_ssim(texture(128, 96, 2, 1), truth, mask), moved - 0.2);
  EXPECT_LT(cw_ssim(texture(128, 96, 1, 4), truth, mask), moved);
  Random random(3);
  EXPECT_LT(
      cw_ssim(changed(truth, [&](double v, int, int) { return v + 40 * random.normal(); }), truth, mask),
      moved);
}

TEST(CwSsim, DoesNotCareWhichDirectionDetailRuns) {
  // A grating at any angle is caught by some orientation: inverted it has the same magnitudes, so the score
  // stays high.
  const Image mask(96, 96, 1, 255);
  for (int degrees : {0, 20, 45, 70, 90, 135}) {
    const double c = std::cos(degrees * 0.01745329), s = std::sin(degrees * 0.01745329);
    auto grating = [&](double phase) {
      return changed(Image(96, 96, 1), [&](double, int x, int y) {
        return 127.5 + 80 * std::sin(0.8 * (c * x + s * y) + phase);
      });
    };
    EXPECT_GT(cw_ssim(grating(0.5), grating(0), mask), 0.9) << degrees;
  }
}

TEST(CwSsim, TakesPicturesThatAreFlatUpToRoundingForAlike) {
  Random random(3);
  const Image flat(96, 96, 1, 90), mask(96, 96, 1, 255);
  const Image rounded = changed(flat, [&](double v, int, int) { return v + random.uniform(-1, 1); });
  EXPECT_GT(cw_ssim(rounded, flat, mask), 0.7);
}

TEST(CwSsim, WorksOnAMaskOfOnePixel) {
  const Image a = texture(20, 20, 1), mask = box_mask(20, 20, 7, 9, 8, 10);
  EXPECT_NEAR(cw_ssim(a, a, mask), 1, 1e-9);
}

}  // namespace
}  // namespace floatstage::pipeline
