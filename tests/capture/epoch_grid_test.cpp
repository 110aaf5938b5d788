#include "capture/epoch_grid.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::capture {
namespace {

constexpr double kPeriod = 1e9 / 30;

Timestamp at(double ns) { return {std::llround(ns)}; }

TEST(EpochGrid, NeverSlipsAgainstCamerasThatAreOffTheirNominalRate) {
  for (const double rate : {29.97, 30.03, 30 * 1.0001}) {
    EpochGrid grid(30, {0});
    std::int64_t row = 0;
    for (int i = 0; i < 60 * 60 * 30; ++i) {
      row = grid.row_of(at(i * 1e9 / rate), i == 0 ? std::nullopt : std::optional(row + 1));
      ASSERT_EQ(row, i) << rate;
    }
    EXPECT_NEAR(static_cast<double>(grid.instant(row).ns), row * 1e9 / rate, 10) << rate;
  }
}

TEST(EpochGrid, LosesNothingToJitterOfHalfAPeriod) {
  EpochGrid grid(30, {0});
  Random random(7);
  std::int64_t row = grid.row_of({0}, std::nullopt);
  for (int i = 1; i < 10'000; ++i) {
    row = grid.row_of(at(kPeriod * (i + 0.5 * (2 * random.uniform() - 1))), row + 1);
    ASSERT_EQ(row, i);
  }
}

TEST(EpochGrid, BelievesTheTimeWhereACountIsAPeriodOff) {
  EpochGrid grid(30, {0});
  EXPECT_EQ(grid.row_of({0}, std::nullopt), 0);
  EXPECT_EQ(grid.row_of(at(3 * kPeriod), 1), 3);
  EXPECT_EQ(grid.row_of(at(4 * kPeriod), 4), 4);
  EXPECT_EQ(grid.row_of(at(4 * kPeriod), 5), 4) << "the same instant again";
}

TEST(EpochGrid, KeepsCamerasThatRunFreelyInTheirRows) {
  // Half a period apart, where rounding alone would throw a coin at every picture.
  EpochGrid grid(30, {0});
  Random random(3);
  std::int64_t a = grid.row_of({0}, std::nullopt), b = grid.row_of(at(0.5 * kPeriod), std::nullopt);
  const std::int64_t apart = b - a;
  for (int i = 1; i < 2000; ++i) {
    a = grid.row_of(at(kPeriod * (i + 0.02 * random.uniform())), a + 1);
    b = grid.row_of(at(kPeriod * (i + 0.5 + 0.02 * random.uniform())), b + 1);
    ASSERT_EQ(a, i);
    ASSERT_EQ(b - a, apart);
  }
}

TEST(EpochGrid, FindsTheRowAgainAfterEverybodyWasAway) {
  EpochGrid grid(30, {0});
  std::int64_t row = grid.row_of({0}, std::nullopt);
  for (int i = 1; i < 3000; ++i) row = grid.row_of(at(i * 1e9 / 29.97), row + 1);
  EXPECT_EQ(grid.row_of(at(6000 * 1e9 / 29.97), std::nullopt), 6000);
  EXPECT_LT(grid.row_of(at(-1e9), std::nullopt), 0);
}

}  // namespace
}  // namespace floatstage::capture
