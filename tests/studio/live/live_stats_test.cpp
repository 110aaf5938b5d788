#include "studio/live/live_stats.h"

#include <gtest/gtest.h>

namespace floatstage::studio {
namespace {

TEST(Series, HasThePercentilesOfItsValues) {
  Series s;
  EXPECT_EQ(s.percentile(0.5), 0) << "of nothing";
  for (int i = 100; i >= 1; --i) s.add(i);
  EXPECT_EQ(s.percentile(0.5), 50);
  EXPECT_EQ(s.percentile(0.99), 99);
  EXPECT_EQ(s.largest(), 100);
  EXPECT_DOUBLE_EQ(s.mean(), 50.5);
}

TEST(Rate, FindsTheSlowestSecond) {
  Rate rate;
  for (int second : {0, 0, 0, 1, 1, 2, 2, 2}) rate.add(second + 0.5);
  EXPECT_DOUBLE_EQ(rate.mean(3), 8.0 / 3);
  EXPECT_DOUBLE_EQ(rate.slowest(3, 1), 2);
  EXPECT_DOUBLE_EQ(rate.slowest(3, 2), 2.5);
  EXPECT_DOUBLE_EQ(rate.slowest(4, 1), 0) << "a second without any";
  EXPECT_DOUBLE_EQ(rate.slowest(0.5, 1), rate.mean(0.5)) << "shorter than a window";
}

}  // namespace
}  // namespace floatstage::studio
