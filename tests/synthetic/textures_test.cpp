#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/synthetic/bitmap_font.h"
#include "core/synthetic/materials.h"
#include "core/synthetic/noise.h"

namespace floatstage::synthetic {
namespace {

TEST(ValueNoise, StaysInRangeWithMeanOneHalfAndIsContinuous) {
  double sum = 0;
  int count = 0;
  for (float x = -9; x < 9; x += 0.37f) {
    for (float y = -9; y < 9; y += 0.41f) {
      const float v = value_noise({x, y, 0.3f * x}, 5);
      ASSERT_GE(v, 0);
      ASSERT_LE(v, 1);
      ASSERT_NEAR(value_noise({x + 1e-3f, y, 0.3f * x}, 5), v, 0.004);
      sum += v;
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 0.5, 0.03);
}

TEST(ValueNoise, DependsOnItsSeed) {
  EXPECT_NE(value_noise({0.2f, 0.4f, 0.6f}, 1), value_noise({0.2f, 0.4f, 0.6f}, 2));
}

TEST(Stripes, AreSharpUpCloseAndFadeToTheirMeanFromAfar) {
  EXPECT_NEAR(stripes(0.1f, 1, 0.3f, 1e-5f), 1, 1e-3);
  EXPECT_NEAR(stripes(0.5f, 1, 0.3f, 1e-5f), 0, 1e-3);
  EXPECT_NEAR(stripes(-0.9f, 1, 0.3f, 1e-5f), 1, 1e-3) << "also left of the origin";
  for (float x = -2; x < 2; x += 0.1f) EXPECT_NEAR(stripes(x, 1, 0.3f, 40), 0.3f, 0.02);
}

TEST(Stripes, KeepTheirMeanAtEveryWindow) {
  for (float window : {0.01f, 0.4f, 1.7f}) {
    double sum = 0;
    for (int i = 0; i < 1000; ++i) sum += stripes(static_cast<float>(i) / 100, 1, 0.3f, window);
    EXPECT_NEAR(sum / 1000, 0.3, 0.005) << window;
  }
}

// The letter as the reader sees it, a row of characters per row of dots.
std::string printed(std::string_view line) {
  std::string rows;
  for (int y = 0; y < kGlyphHeight; ++y) {
    for (int x = 0; x < static_cast<int>(printed_width(line)); ++x)
      rows += printed_ink(line, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, 0.01f) > 0.5f
                  ? '#'
                  : '.';
    rows += '\n';
  }
  return rows;
}

TEST(PrintedInk, ReadsFromLeftToRightAndFromTopToBottom) {
  EXPECT_EQ(printed("F1"),
            "#####...#..\n"
            "#......##..\n"
            "#.......#..\n"
            "####....#..\n"
            "#.......#..\n"
            "#.......#..\n"
            "#......###.\n");
}

TEST(PrintedInk, HasNoInkOutsideItsLineAndNoneInBlanks) {
  for (float x : {-1.0f, 11.6f, 30.0f}) EXPECT_EQ(printed_ink("HI", x, 3.5f, 0.1f), 0) << x;
  for (float y : {-1.2f, 8.2f}) EXPECT_EQ(printed_ink("HI", 0.5f, y, 0.1f), 0) << y;
  EXPECT_EQ(printed("  ").find('#'), std::string::npos);
}

TEST(Albedo, IsAColourForEveryMaterialEverywhere) {
  for (int m = 0; m <= static_cast<int>(Material::Strand); ++m) {
    for (float z = -0.2f; z < 1; z += 0.013f) {
      for (float angle = 0; angle < 6.28f; angle += 0.4f) {
        const int variant = static_cast<Material>(m) == Material::Strand ? 2 : -1;
        const Eigen::Vector3f c = albedo(
            {static_cast<Material>(m), variant, {0.1f * std::cos(angle), 0.1f * std::sin(angle), z}, 0.002f},
            3);
        ASSERT_TRUE(c.allFinite());
        ASSERT_GE(c.minCoeff(), 0) << "material " << m;
        ASSERT_LE(c.maxCoeff(), 1.2f) << "material " << m;
      }
    }
  }
}

TEST(Albedo, IsNeverTheGreenOfTheCloth) {
  for (int m = 0; m <= static_cast<int>(Material::Strand); ++m) {
    for (float z = -0.2f; z < 1; z += 0.007f) {
      for (float angle = 0; angle < 6.28f; angle += 0.2f) {
        const Eigen::Vector3f c = albedo(
            {static_cast<Material>(m), 1, {0.1f * std::cos(angle), 0.1f * std::sin(angle), z}, 0.001f}, 3);
        ASSERT_LT(c.y() - std::max(c.x(), c.z()), 0.03f) << "material " << m;
      }
    }
  }
}

TEST(Albedo, KeepsItsMeanWhenThePatternIsFinerThanThePixel) {
  // Down a sleeve, over a whole number of stripes: the fine picture's mean is the coarse picture's.
  auto mean = [](float footprint) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i)
      sum += albedo(
          {Material::Sleeve, 1, {0, 0.05f, 0.034f * 10 * static_cast<float>(i) / kSteps}, footprint}, 3);
    return Eigen::Vector3f(sum / kSteps);
  };
  EXPECT_LT((mean(0.0002f) - mean(0.02f)).cwiseAbs().maxCoeff(), 0.03f);
}

}  // namespace
}  // namespace floatstage::synthetic
