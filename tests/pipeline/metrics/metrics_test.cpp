#include "pipeline/metrics/metrics.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/check.h"
#include "tests/pipeline/metrics/textures.h"

namespace floatstage::pipeline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Every metric, for what holds of all of them.
struct Metric {
  const char* name;
  double (*of)(const Image&, const Image&, const Image&);
  double perfect;
};

class AnyMetric : public ::testing::TestWithParam<Metric> {};

TEST_P(AnyMetric, IsPerfectForIdenticalPictures) {
  const Image picture = texture(70, 50, 3, 2, 3);
  EXPECT_DOUBLE_EQ(GetParam().of(picture, picture, box_mask(70, 50, 9, 7, 60, 44)), GetParam().perfect);
  EXPECT_DOUBLE_EQ(GetParam().of(picture, picture, Image(70, 50, 1, 255)), GetParam().perfect);
}

TEST_P(AnyMetric, IsNotANumberWhenTheMaskIsEmpty) {
  const Image picture = texture(30, 20);
  EXPECT_TRUE(std::isnan(GetParam().of(picture, picture, Image(30, 20, 1, 127))));
}

TEST_P(AnyMetric, SeesNothingOutsideTheMask) {
  const Image truth = texture(70, 50, 3), rendered = texture(70, 50, 4);
  Image mask = box_mask(70, 50, 9, 7, 60, 44);
  *mask.at(30, 20) = 0;  // a hole
  auto spoiled = [&](const Image& image, double value) {
    return changed(image, [&](double v, int x, int y) { return *mask.at(x, y) >= 128 ? v : value; });
  };
  const double clean = GetParam().of(rendered, truth, mask);
  EXPECT_DOUBLE_EQ(GetParam().of(spoiled(rendered, 255), truth, mask), clean);
  EXPECT_DOUBLE_EQ(GetParam().of(rendered, spoiled(truth, 0), mask), clean);
}

TEST_P(AnyMetric, DropsWhenHalfThePictureIsReplaced) {
  const Image truth = texture(70, 50, 3), other = texture(70, 50, 4, 0);
  const Image half = changed(truth, [&](double v, int x, int y) { return x < 35 ? v : *other.at(x, y); });
  const double value = GetParam().of(half, truth, Image(70, 50, 1, 255));
  if (std::isinf(GetParam().perfect)) {
    EXPECT_LT(value, 30);
  } else {
    EXPECT_GT(std::abs(value - GetParam().perfect), 0.2);
  }
}

TEST_P(AnyMetric, RefusesPicturesThatDoNotBelongTogether) {
  const Image picture = texture(30, 20), mask(30, 20, 1, 255);
  EXPECT_THROW(GetParam().of(texture(30, 21), picture, mask), CheckFailure);
  EXPECT_THROW(GetParam().of(texture(30, 20, 1, 2, 3), picture, mask), CheckFailure);
  EXPECT_THROW(GetParam().of(picture, picture, Image(20, 30, 1, 255)), CheckFailure);
}

INSTANTIATE_TEST_SUITE_P(All, AnyMetric,
                         ::testing::Values(Metric{"psnr", psnr, kInfinity}, Metric{"ssim", ssim, 1},
                                           Metric{"cw_ssim", cw_ssim, 1},
                                           Metric{"psnr_shift", psnr_shift, kInfinity},
                                           Metric{"sharpness", sharpness, 1}),
                         [](const auto& suite) { return std::string(suite.param.name); });

TEST(Psnr, OfAConstantOffsetIsKnown) {
  const Image truth(20, 10, 3, 100), rendered(20, 10, 3, 105);
  EXPECT_NEAR(psnr(rendered, truth, Image(20, 10, 1, 255)), 20 * std::log10(255 / 5.0), 1e-12);
}

TEST(Psnr, OfGaussianNoiseIsKnown) {
  Random random(5);
  const Image truth(200, 200, 3, 128);
  const Image noisy = changed(truth, [&](double v, int, int) { return v + 10 * random.normal(); });
  EXPECT_NEAR(psnr(noisy, truth, Image(200, 200, 1, 255)), 20 * std::log10(255 / 10.0), 0.05);
}

TEST(Psnr, AveragesOverChannelsAndMaskOnly) {
  Image truth(4, 1, 3, 50), rendered = truth, mask(4, 1, 1);
  rendered.at(0, 0)[1] = 56;  // 36 over two pixels of three channels
  rendered.at(3, 0)[1] = 255;
  *mask.at(0, 0) = *mask.at(1, 0) = 128;
  EXPECT_NEAR(psnr(rendered, truth, mask), 10 * std::log10(255.0 * 255 / 6), 1e-12);
}

TEST(PsnrShift, ForgivesAMisplacementUpToThreePixels) {
  const Image truth = texture(96, 80, 2, 1), mask = box_mask(96, 80, 8, 8, 88, 72);
  for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{-3, 2}, std::pair{3, 3}}) {
    const Image rendered = shifted(truth, dx, dy);
    EXPECT_EQ(psnr_shift(rendered, truth, mask), kInfinity) << dx << ' ' << dy;
    EXPECT_LT(psnr(rendered, truth, mask), 25) << dx << ' ' << dy;
  }
  const Image far = shifted(truth, 5, 0);
  EXPECT_LT(psnr_shift(far, truth, mask), 28);
}

TEST(PsnrShift, LetsEachBlockChooseItsOwn) {
  const Image truth = texture(64, 32, 2, 1), left = shifted(truth, 2, 0), right = shifted(truth, -2, 1);
  const Image rendered = changed(left, [&](double v, int x, int y) { return x < 32 ? v : *right.at(x, y); });
  const Image mask(64, 32, 1, 255);
  EXPECT_GT(psnr_shift(rendered, truth, mask), psnr(rendered, truth, mask) + 6);
}

TEST(PsnrShift, IsNeverBelowPsnrAndDoesNotForgiveAnOffset) {
  const Image truth = texture(64, 48), mask(64, 48, 1, 255);
  const Image brighter = changed(truth, [](double v, int, int) { return v + 20; });
  EXPECT_GE(psnr_shift(brighter, truth, mask), psnr(brighter, truth, mask));
  EXPECT_LT(psnr_shift(brighter, truth, mask), psnr(brighter, truth, mask) + 3);
}

TEST(Sharpness, HalvesOfTheContrastAreAQuarterOfTheEnergy) {
  const Image truth = texture(64, 48, 1, 1), mask(64, 48, 1, 255);
  const Image flat = changed(truth, [](double v, int, int) { return 127.5 + 0.5 * (v - 127.5); });
  EXPECT_NEAR(sharpness(flat, truth, mask), 0.25, 0.005);
}

TEST(Sharpness, FallsWithBlurAndRisesWithNoise) {
  const Image truth = texture(64, 48, 1, 1), blurred = texture(64, 48, 1, 2), mask(64, 48, 1, 255);
  // texture() stretches, so bring the blurred one back to the sharp one's scale by a smaller contrast.
  const Image soft = changed(blurred, [](double v, int, int) { return 127.5 + 0.6 * (v - 127.5); });
  EXPECT_LT(sharpness(soft, truth, mask), 0.5);
  Random random(1);
  const Image noisy = changed(truth, [&](double v, int, int) { return v + 20 * random.normal(); });
  EXPECT_GT(sharpness(noisy, truth, mask), 1.1);
}

TEST(Sharpness, IsUndefinedForAFlatTruthAndAMaskWithoutInterior) {
  const Image picture = texture(20, 20);
  EXPECT_TRUE(std::isnan(sharpness(picture, Image(20, 20, 1, 90), Image(20, 20, 1, 255))));
  EXPECT_TRUE(std::isnan(sharpness(picture, picture, box_mask(20, 20, 5, 5, 7, 7))));
}

TEST(Score, PutsEachFigureInItsPlace) {
  const Image truth = texture(64, 48, 1, 2, 3), rendered = texture(64, 48, 2, 2, 3);
  const Image mask = box_mask(64, 48, 10, 10, 50, 40), silhouette = box_mask(64, 48, 5, 5, 60, 45);
  const Scores s = score(rendered, truth, mask, silhouette);
  EXPECT_EQ(s.psnr, psnr(rendered, truth, mask));
  EXPECT_EQ(s.ssim, ssim(rendered, truth, mask));
  EXPECT_EQ(s.cw_ssim, cw_ssim(rendered, truth, mask));
  EXPECT_EQ(s.psnr_shift, psnr_shift(rendered, truth, mask));
  EXPECT_EQ(s.sharpness, sharpness(rendered, truth, mask));
  EXPECT_EQ(s.psnr_full, psnr(rendered, truth, silhouette));
  EXPECT_NE(s.psnr, s.psnr_full);
}

TEST(ErodeMask, TakesADiscOffEveryEdgeButThePictures) {
  EXPECT_EQ(erode_mask(box_mask(40, 30, 5, 6, 30, 20), 2), box_mask(40, 30, 7, 8, 28, 18));
  EXPECT_EQ(erode_mask(box_mask(40, 30, 0, 0, 30, 20), 2), box_mask(40, 30, 0, 0, 28, 18));
  EXPECT_EQ(erode_mask(Image(8, 8, 1, 200), 3), Image(8, 8, 1, 255));
  Image hole(11, 11, 1, 255);
  *hole.at(5, 5) = 0;
  const Image grown = erode_mask(hole, 2);
  int gone = 0;
  for (std::uint8_t v : grown.pixels) gone += v == 0;
  EXPECT_EQ(gone, 13) << "the pixels of a disc of radius 2";
}

TEST(ErodeMask, ByNothingOnlyDecidesAndOfNothingIsNothing) {
  EXPECT_EQ(erode_mask(Image(3, 3, 1, 128), 0), Image(3, 3, 1, 255));
  EXPECT_EQ(erode_mask(Image(3, 3, 1, 127), 0), Image(3, 3, 1, 0));
  EXPECT_EQ(erode_mask(box_mask(9, 9, 4, 4, 5, 5), 1), Image(9, 9, 1, 0));
}

TEST(PsnrColor, ForgivesAGainAndAnOffsetAChannel) {
  const Image truth = texture(60, 40, 5, 2, 3);
  Image rendered = truth;
  for (std::size_t i = 0; i < rendered.pixels.size(); ++i)
    rendered.pixels[i] = static_cast<std::uint8_t>(
        std::lround((0.5 + 0.1 * static_cast<double>(i % 3)) * truth.pixels[i] + 20));
  const Image mask(60, 40, 1, 255);
  EXPECT_LT(psnr(rendered, truth, mask), 20);
  EXPECT_GT(psnr_color(rendered, truth, mask), 50);
  EXPECT_LT(psnr_color(texture(60, 40, 6, 2, 3), truth, mask), 20) << "another picture stays another";
}

TEST(OutlineBand, LiesHalfOnEachSideOfTheOutlineAndNotAlongThePicturesEdge) {
  const Image band = outline_band(box_mask(40, 30, 0, 10, 20, 30), 6);
  EXPECT_EQ(*band.at(5, 6), 0);
  for (int y = 7; y <= 12; ++y) EXPECT_EQ(*band.at(5, y), 255) << y;
  EXPECT_EQ(*band.at(5, 13), 0);
  EXPECT_EQ(*band.at(0, 20), 0) << "the subject goes on beyond the picture";
  EXPECT_EQ(*band.at(5, 29), 0);
  EXPECT_EQ(*band.at(20, 20), 255);
}

// The flicker from one rendered picture to another of truths that are all alike.
double flicker_of(const Image& before, const Image& now, const Image& truth, const Image& mask) {
  return flicker(picture_error(now, truth, mask), picture_error(before, truth, mask));
}

TEST(Flicker, IsHowMuchTheErrorChangesAndNotHowLargeItIs) {
  const Image truth = texture(40, 30, 3), mask(40, 30, 1, 255);
  const Image brighter = changed(truth, [](double v, int, int) { return v + 20; }),
              darker = changed(truth, [](double v, int, int) { return v - 10; });
  EXPECT_DOUBLE_EQ(flicker_of(brighter, brighter, truth, mask), 0);
  EXPECT_NEAR(flicker_of(brighter, darker, truth, mask), 30, 1) << "but where it is cut at 0 or 255";
  EXPECT_DOUBLE_EQ(flicker_of(truth, truth, truth, mask), 0);
}

TEST(Flicker, OfATruthThatMovesIsThatOfTheErrors) {
  const Image first = texture(40, 30, 3), second = texture(40, 30, 4), mask(40, 30, 1, 255);
  EXPECT_DOUBLE_EQ(flicker(picture_error(second, second, mask), picture_error(first, first, mask)), 0);
}

TEST(Flicker, LooksWhereBothMasksAre) {
  const Image truth(40, 30, 3, 100);
  const Image left = box_mask(40, 30, 0, 0, 25, 30), right = box_mask(40, 30, 15, 0, 40, 30);
  const Image now = changed(truth, [](double v, int x, int) { return x >= 15 && x < 25 ? v + 8 : v + 99; });
  EXPECT_DOUBLE_EQ(flicker(picture_error(now, truth, right), picture_error(truth, truth, left)), 8);
  const Image far = box_mask(40, 30, 30, 0, 40, 30);
  EXPECT_TRUE(std::isnan(flicker(picture_error(now, truth, far), picture_error(truth, truth, left))));
  EXPECT_TRUE(std::isnan(flicker(picture_error(now, truth, left),
                                 picture_error(Image(9, 9, 3), Image(9, 9, 3), Image(9, 9, 1, 255)))));
}

}  // namespace
}  // namespace floatstage::pipeline
