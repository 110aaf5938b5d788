#include "pipeline/metrics/matte_metrics.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/check.h"
#include "core/matte.h"
#include "tests/pipeline/metrics/textures.h"

namespace floatstage::pipeline {
namespace {

// 40x30, subject from (10, 8) to (30, 22), both ends as box_mask() takes them.
Image box() { return box_mask(40, 30, 10, 8, 30, 22); }
Image flat(std::uint8_t alpha) { return Image(40, 30, 1, alpha); }

TEST(MatteScores, ArePerfectForTheTruthItself) {
  for (const Image& matte : {box(), flat(0), flat(255), texture(40, 30)}) {
    const MatteScores s = score_matte(matte, matte);
    EXPECT_EQ(s.sad, 0);
    EXPECT_EQ(s.mad, 0);
    EXPECT_EQ(s.mse, 0);
    EXPECT_EQ(s.gradient, 0);
    EXPECT_EQ(s.connectivity, 0);
    EXPECT_EQ(s.iou, 1);
    EXPECT_EQ(s.boundary_f, 1);
    EXPECT_EQ(matte_dtssd(matte, matte, matte, matte), 0);
  }
}

TEST(MatteDifferences, OfAnEvenErrorAreItsSizeAndSquare) {
  EXPECT_NEAR(matte_sad(flat(51), flat(0)), 0.2 * 1200, 1e-9);
  EXPECT_NEAR(matte_mad(flat(51), flat(0)), 0.2, 1e-12);
  EXPECT_NEAR(matte_mse(flat(51), flat(0)), 0.04, 1e-12);
  EXPECT_DOUBLE_EQ(matte_sad(flat(255), flat(0)), 1200);
  EXPECT_DOUBLE_EQ(matte_mse(flat(0), flat(255)), 1);
}

TEST(MatteDifferences, CountOnePixelAsOne) {
  Image wrong = box();
  *wrong.at(0, 0) = 255;
  EXPECT_DOUBLE_EQ(matte_sad(wrong, box()), 1);
  EXPECT_DOUBLE_EQ(matte_mse(wrong, box()), 1.0 / 1200);
}

TEST(MatteGradientError, IsBlindToAnEvenErrorAndSeesARampAsItsSlope) {
  EXPECT_NEAR(matte_gradient_error(flat(255), flat(0)), 0, 1e-20);
  // A ramp of 5/255 a pixel: the response of unit-norm kernels to it, away from the borders, by hand.
  Image ramp(40, 30, 1);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) *ramp.at(x, y) = static_cast<std::uint8_t>(5 * x);
  double g1 = 0, g2 = 0, d1 = 0, d2 = 0;
  for (int k = -4; k <= 4; ++k) {
    const double g = std::exp(-k * k / (2 * 1.4 * 1.4));
    g1 += g, g2 += g * g, d1 += k * k * g, d2 += k * k * g * g;
  }
  const double response = 5 / 255.0 * g1 * d1 / std::sqrt(g2 * d2);
  const double inner = 32 * 30 * response * response;  // columns 4 … 35; the outer eight see less of the ramp
  const double error = matte_gradient_error(ramp, flat(0));
  EXPECT_GT(error, inner);
  EXPECT_LT(error, inner * 40 / 32);
}

TEST(MatteConnectivityError, CountsAnIslandAndForgivesASmallLoss) {
  Image island = box();
  for (int i = 0; i < 3; ++i) *island.at(i, 0) = 255;
  EXPECT_NEAR(matte_connectivity_error(island, box()), 3, 1e-9)
      << "three opaque pixels that hang together with nothing";
  Image paler = box();
  *paler.at(20, 15) = 235;  // 0.92: connected up to 0.9, the truth is 0.1 above that
  EXPECT_NEAR(matte_connectivity_error(paler, box()), 0, 1e-9);
  *paler.at(20, 15) = 128;  // connected up to 0.5: the truth is 0.5 above it, the matte 0.002
  EXPECT_NEAR(matte_connectivity_error(paler, box()), 0.5, 1e-9);
}

TEST(MatteIou, IsTheShareOfWhatEitherCallsSubject) {
  const Image left = box_mask(40, 30, 10, 8, 20, 18), right = box_mask(40, 30, 15, 8, 25, 18);
  EXPECT_DOUBLE_EQ(matte_iou(left, right), iou(make_matte({}, left), make_matte({}, right)));
  EXPECT_NEAR(matte_iou(left, right), 1.0 / 3, 0.05);
  EXPECT_EQ(matte_iou(left, flat(0)), 0);
  EXPECT_EQ(matte_iou(flat(0), flat(127)), 1) << "no subject in either";
}

TEST(MatteBoundaryF, ForgivesOnePixelAndNoMore) {
  const Image truth = box_mask(40, 30, 10, 8, 30, 22);
  EXPECT_EQ(matte_boundary_f(box_mask(40, 30, 11, 8, 31, 22), truth), 1);
  const double two = matte_boundary_f(box_mask(40, 30, 12, 8, 32, 22), truth);
  EXPECT_LT(two, 0.75) << "both upright sides are lost";
  EXPECT_GT(two, 0.4) << "most of the level sides is not";
  EXPECT_EQ(matte_boundary_f(flat(0), truth), 0);
  EXPECT_EQ(matte_boundary_f(flat(255), flat(0)), 1) << "a picture's edge is no boundary";
}

TEST(MatteDtssd, SeesFlickerAndNotMotionOrAConstantError) {
  EXPECT_EQ(matte_dtssd(flat(10), flat(60), flat(0), flat(50)), 0) << "moves as the truth does";
  EXPECT_NEAR(matte_dtssd(flat(0), flat(51), flat(0), flat(0)), 0.2, 1e-12);
  EXPECT_NEAR(matte_dtssd(flat(0), flat(0), flat(0), flat(51)), 0.2, 1e-12)
      << "standing still is flicker too";
}

TEST(MatteScores, RefusePicturesThatAreNoPair) {
  EXPECT_THROW(matte_sad(Image(3, 3, 3), Image(3, 3, 3)), CheckFailure);
  EXPECT_THROW(matte_iou(flat(0), Image(30, 40, 1)), CheckFailure);
  EXPECT_THROW(score_matte(flat(0), Image(40, 31, 1)), CheckFailure);
}

}  // namespace
}  // namespace floatstage::pipeline
