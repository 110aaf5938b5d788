#include "studio/live/live_pace.h"

#include <gtest/gtest.h>

namespace floatstage::studio {
namespace {

Timestamp ms(std::int64_t n) { return {n * 1'000'000}; }

// `count` pictures in the second that begins at `second`, each at work for `work_ms`.
void draw(LivePace& pace, int second, int count, int work_ms, double latency_ms) {
  for (int i = 0; i < count; ++i) {
    const std::int64_t begun = 1000 * second + i * 1000 / count;
    pace.drew(ms(begun), ms(begun + work_ms), latency_ms);
  }
}

TEST(LivePace, TellsTheScenesOfTheLastSecond) {
  LivePace pace(0, 1);
  draw(pace, 0, 20, 10, 80);
  EXPECT_FALSE(pace.judge(ms(999), 25, true));
  ASSERT_TRUE(pace.judge(ms(1000), 25, true));
  EXPECT_DOUBLE_EQ(pace.fps(), 20);
  EXPECT_DOUBLE_EQ(pace.latency_ms(), 80);
  draw(pace, 1, 5, 10, 120);
  ASSERT_TRUE(pace.judge(ms(2000), 25, true));
  EXPECT_DOUBLE_EQ(pace.fps(), 5);
  EXPECT_DOUBLE_EQ(pace.latency_ms(), 120);
}

TEST(LivePace, DoesNotCountPicturesThatShowNothingNew) {
  LivePace pace(0, 1);
  for (int i = 0; i < 20; ++i)
    pace.drew(ms(50 * i), ms(50 * i + 10), i % 2 == 0 ? std::optional(90.0) : std::nullopt);
  ASSERT_TRUE(pace.judge(ms(1000), 25, true));
  EXPECT_DOUBLE_EQ(pace.fps(), 10);
}

TEST(LivePace, SaysNothingBeforeTheFirstPicture) {
  LivePace pace(12, 1);
  EXPECT_FALSE(pace.judge(ms(5000), 25, true));
}

TEST(LivePace, LowersTheQualityOnlyWhereItIsAutomatic) {
  for (const bool automatic : {true, false}) {
    LivePace pace(12, 1);
    for (int s = 0; s < 4; ++s) {
      draw(pace, s, 5, 150, 300);
      ASSERT_TRUE(pace.judge(ms(1000 * (s + 1)), 25, automatic));
    }
    EXPECT_EQ(pace.quality(), automatic ? 3U : 1U);
  }
}

TEST(LivePace, GoesOnFromTheOperatorsChoice) {
  LivePace pace(12, 1);
  pace.choose(4);
  EXPECT_EQ(pace.quality(), 4U);
  for (int s = 0; s < 2; ++s) {
    draw(pace, s, 5, 150, 300);
    ASSERT_TRUE(pace.judge(ms(1000 * (s + 1)), 25, true));
  }
  EXPECT_EQ(pace.quality(), 5U);
}

}  // namespace
}  // namespace floatstage::studio
