#include "core/color.h"

#include <cmath>

#include <gtest/gtest.h>

namespace floatstage {
namespace {

ColorTransform warm_camera() {
  ColorTransform t;
  t.matrix << 1.1, -0.05, 0, 0.02, 0.9, 0.03, 0, -0.1, 1.3;
  t.decode = {2.2, 2.0, 2.4};
  t.encode = 2.2;
  return t;
}

TEST(ColorTransform, DoesNothingByDefault) {
  EXPECT_TRUE(ColorTransform{}.is_identity());
  EXPECT_TRUE(apply(ColorTransform{}, {0.2, 0.5, 1}).isApprox(Eigen::Vector3d(0.2, 0.5, 1)));
  EXPECT_FALSE(warm_camera().is_identity());
}

TEST(ColorTransform, RaisesMixesAndRaisesBack) {
  ColorTransform t;
  t.matrix = Eigen::Vector3d(0.5, 1, 2).asDiagonal();
  t.decode.setConstant(2);
  t.encode = 2;
  EXPECT_TRUE(apply(t, {0.4, 0.4, 0.9}).isApprox(Eigen::Vector3d(0.4 * std::sqrt(0.5), 0.4, 1), 1e-12))
      << "clamped at 1";
}

TEST(ColorTable, AgreesWithTheFormulaToOneLevel) {
  for (const ColorTransform& t : {warm_camera(), ColorTransform{}}) {
    const ColorTable table(t);
    for (int r = 0; r < 256; r += 15) {
      for (int g = 0; g < 256; g += 15) {
        for (int b = 0; b < 256; b += 15) {
          std::uint8_t rgb[3] = {static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g),
                                 static_cast<std::uint8_t>(b)};
          const Eigen::Vector3d exact = 255 * apply(t, Eigen::Vector3d(r, g, b) / 255);
          table.apply(rgb, rgb);
          for (int i = 0; i < 3; ++i) ASSERT_NEAR(rgb[i], exact[i], 1.01) << r << ' ' << g << ' ' << b;
        }
      }
    }
  }
}

TEST(ColorTable, OfTheIdentityKeepsEveryByte) {
  const ColorTable table(ColorTransform{});
  for (int v = 0; v < 256; ++v) {
    std::uint8_t rgb[3] = {static_cast<std::uint8_t>(v), 0, static_cast<std::uint8_t>(255 - v)};
    table.apply(rgb, rgb);
    EXPECT_EQ(rgb[0], v);
    EXPECT_EQ(rgb[2], 255 - v);
  }
}

}  // namespace
}  // namespace floatstage
