#include "calib/gain_balance.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::calib {
namespace {

using Gains = std::vector<Eigen::Vector3d>;

Gains gains_of(const GainBalance& balance) {
  Gains gains;
  for (const ColorTransform& t : balance.transforms) gains.emplace_back(t.matrix.diagonal());
  return gains;
}

// What cameras of these sensitivities see of a surface; each point is seen by `overlap` neighbours, and one
// in ten of the sights is of something else.
std::vector<ColorSample> seen_by(const Gains& sensitivity, int points, int overlap) {
  Random random(3);
  std::vector<ColorSample> samples;
  const auto cameras = static_cast<int>(sensitivity.size());
  for (int p = 0; p < points; ++p) {
    const Eigen::Vector3d color(random.uniform(0.15, 0.7), random.uniform(0.15, 0.7),
                                random.uniform(0.15, 0.7));
    for (int k = 0; k < overlap; ++k) {
      const int c = (p + k) % cameras;
      Eigen::Vector3d seen = color.cwiseProduct(sensitivity[static_cast<std::size_t>(c)]);
      if (random.uniform(0, 1) < 0.1) seen *= random.uniform(0.4, 1.3);
      samples.push_back({c, p, seen});
    }
  }
  return samples;
}

TEST(GainBalance, UndoesWhatCamerasDifferByAndLeavesTheirMean) {
  const Gains sensitivity = {{0.8, 0.9, 1.1}, {1.2, 1, 1}, {1, 1.05, 0.9}, {0.95, 0.85, 1.2}};
  const Gains gains = gains_of(balance_gains(seen_by(sensitivity, 4000, 3), sensitivity.size()));
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& s : sensitivity) mean += s.array().log().matrix() / 4;
  for (std::size_t i = 0; i < gains.size(); ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(gains[i][c] * sensitivity[i][c], std::exp(mean[c]), 0.012) << "camera " << i;
}

TEST(GainBalance, CarriesARingOfCamerasThatShareWithTheirNeighboursOnly) {
  Gains sensitivity;
  for (int i = 0; i < 12; ++i)
    sensitivity.emplace_back(Eigen::Vector3d::Constant(1 + 0.2 * std::sin(i * M_PI / 6)));
  const Gains gains = gains_of(balance_gains(seen_by(sensitivity, 6000, 3), sensitivity.size()));
  const double level = gains[0][0] * sensitivity[0][0];
  for (std::size_t i = 0; i < gains.size(); ++i) EXPECT_NEAR(gains[i][1] * sensitivity[i][1], level, 0.03);
}

TEST(GainBalance, LeavesACameraThatSharesNothingAsItIs) {
  std::vector<ColorSample> samples = seen_by({{0.9, 0.9, 0.9}, {1.1, 1.1, 1.1}}, 1000, 2);
  samples.push_back({2, 5000, {0.5, 0.5, 0.5}});
  const GainBalance balance = balance_gains(samples, 4);
  EXPECT_TRUE(balance.transforms[2].is_identity());
  EXPECT_TRUE(balance.transforms[3].is_identity());
  EXPECT_EQ(balance.points[2], 0);
  EXPECT_NEAR(balance.transforms[0].matrix(0, 0), 1 / 0.9, 0.02);
}

TEST(GainBalance, SaysWhoseGainsItKnows) {
  const std::vector<ColorSample> few = seen_by({{0.9, 0.9, 0.9}, {1.1, 1.1, 1.1}}, 99, 2),
                                 enough = seen_by({{0.9, 0.9, 0.9}, {1.1, 1.1, 1.1}}, 100, 2);
  EXPECT_EQ(balance_gains(few, 3).known, std::vector<bool>(3, false));
  EXPECT_TRUE(balance_gains(few, 3).transforms[0].is_identity());
  EXPECT_EQ(balance_gains(enough, 3).known, std::vector<bool>({true, true, false}));
}

TEST(GainBalance, KnowsNothingOfWhatIsDarkOrClipped) {
  std::vector<ColorSample> samples;
  for (int p = 0; p < 500; ++p) {
    samples.push_back({0, p, {0.01, 0.02, 0.01}});
    samples.push_back({1, p, {1, 0.99, 1}});
  }
  for (const ColorTransform& t : balance_gains(samples, 2).transforms) EXPECT_TRUE(t.is_identity());
}

}  // namespace
}  // namespace floatstage::calib
