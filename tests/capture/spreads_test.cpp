#include "capture/spreads.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::capture {
namespace {

constexpr double kShares[] = {0, 0.01, 0.5, 0.9, 0.99, 0.999, 1};

TEST(Spreads, HaveThePercentilesOfTheirValuesToA128th) {
  Random random(7);
  Spreads spreads;
  std::vector<std::int64_t> all;
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(static_cast<std::int64_t>(std::exp(20 * random.uniform())));  // 1 ns to half a second
    spreads.add(all.back());
  }
  for (const double share : kShares) {
    const std::int64_t is = percentile(all, share), said = spreads.percentile(share);
    EXPECT_GE(said, is) << share;
    EXPECT_LE(said - is, is / 128) << share;
    EXPECT_TRUE(std::find(all.begin(), all.end(), said) != all.end()) << share << ": it was seen";
  }
  EXPECT_EQ(spreads.percentile(1), percentile(all, 1));
}

TEST(Spreads, OfFewKindsAreExact) {
  Spreads spreads;
  for (int i = 0; i < 10; ++i) spreads.add(i == 5 ? 3'000'000 : 500'001);
  EXPECT_EQ(spreads.percentile(0.5), 500'001);
  EXPECT_EQ(spreads.percentile(0.9), 500'001);
  EXPECT_EQ(spreads.percentile(0.99), 3'000'000);
  spreads.clear();
  EXPECT_TRUE(spreads.empty());
  spreads.add(0);
  EXPECT_EQ(spreads.percentile(1), 0);
}

TEST(Spreads, TakeNoMoreRoomTheMoreTheyAre) {
  Random random(5);
  Spreads spreads;
  const auto add = [&](int count) {
    for (int i = 0; i < count; ++i) spreads.add(static_cast<std::int64_t>(8e6 * random.uniform()));
  };
  spreads.add(8'000'000);
  const std::size_t bins = spreads.bins();
  add(1'000'000);
  EXPECT_EQ(spreads.bins(), bins);
  EXPECT_LE(bins, 128u * 17);
  spreads.add(std::int64_t{1} << 62);
  EXPECT_LE(spreads.bins(), 128u * 64) << "whatever somebody's clock says";
}

}  // namespace
}  // namespace floatstage::capture
