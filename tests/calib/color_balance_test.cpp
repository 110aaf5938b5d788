#include "calib/color_balance.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

// Four cameras of different gain and gamma around a stage; each point is seen by two neighbours.
struct Odd {
  Eigen::Vector3d gain, gamma;
  Eigen::Vector3d see(const Eigen::Vector3d& rgb) const {
    return (gain.array() * rgb.array().pow(2.2)).pow(1 / gamma.array()).min(1.0);
  }
};
const Odd kOdd[] = {{{1, 1, 1}, {2.2, 2.2, 2.2}},
                    {{0.8, 0.9, 0.6}, {2, 2, 2}},
                    {{0.6, 0.85, 0.95}, {1.8, 1.8, 1.8}},
                    {{0.9, 0.7, 0.6}, {2.5, 2.4, 2.6}}};
const std::vector<std::string> kSerials = {"a", "b", "c", "d"};

std::vector<ColorSample> sights(int wrong_every) {
  Random random(4);
  std::vector<ColorSample> out;
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector3d rgb(random.uniform(0.15, 0.9), random.uniform(0.15, 0.9),
                              random.uniform(0.15, 0.9));
    for (const int c : {i % 4, (i + 1) % 4}) {
      Eigen::Vector3d seen = kOdd[c].see(rgb);
      if (wrong_every > 0 && i % wrong_every == 0 && c == i % 4)
        seen = {random.uniform(), random.uniform(), random.uniform()};
      for (double& v : seen) v = std::round(255 * v) / 255;
      out.push_back({c, i, seen});
    }
  }
  return out;
}

TEST(BalanceColors, MakesCamerasLookLikeTheGivenOneThroughTheirNeighbours) {
  for (const int wrong_every : {0, 13}) {
    const Result<ColorBalance> balance = balance_colors(
        sights(wrong_every), {ColorTransform{}, std::nullopt, std::nullopt, std::nullopt}, kSerials);
    ASSERT_THAT(balance, IsOk());
    EXPECT_TRUE(balance->transforms[0].is_identity());
    Random random(8);
    for (std::size_t c = 1; c < 4; ++c) {
      double mean = 0;
      for (int i = 0; i < 200; ++i) {
        const Eigen::Vector3d rgb(random.uniform(0.2, 0.85), random.uniform(0.2, 0.85),
                                  random.uniform(0.2, 0.85));
        mean +=
            delta_e_2000(lab_from_srgb(apply(balance->transforms[c], kOdd[c].see(rgb))), lab_from_srgb(rgb)) /
            200;
      }
      EXPECT_LE(mean, 1.5) << kSerials[c] << ", one in " << wrong_every << " wrong";
      EXPECT_GT(balance->cameras[c].mean_before, 5);
      EXPECT_LT(balance->cameras[c].mean_after, 1);
      EXPECT_EQ(balance->cameras[c].strays > 0, wrong_every > 0);
    }
  }
}

TEST(BalanceColors, NamesTheCameraThatSharesTooLittle) {
  std::vector<ColorSample> few = sights(0);
  std::erase_if(few, [](const ColorSample& s) { return s.camera == 2 && s.point > 10; });
  EXPECT_THAT(balance_colors(few, {ColorTransform{}, std::nullopt, std::nullopt, std::nullopt}, kSerials),
              FailsWith(ErrorCode::BadData, "camera 'c' shares"));
  EXPECT_THAT(balance_colors(few, std::vector<std::optional<ColorTransform>>(4), kSerials),
              FailsWith(ErrorCode::InvalidArgument, "one camera"));
}

}  // namespace
}  // namespace floatstage::calib
