#include "capture/sound/sound_clock.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::capture {
namespace {

using testing::SizeIs;

constexpr int kRate = 48'000, kPeriod = 480;  // 10 ms, as sound cards deliver

// Stamps of a clock that runs `ppm` fast, read `late_ns` late at most.
std::vector<SoundStamp> stamped(double seconds, double ppm, double late_ns, std::uint64_t seed = 1) {
  Random random(seed);
  std::vector<SoundStamp> out;
  for (std::int64_t s = 0; s < seconds * kRate; s += kPeriod) {
    const double time = 5e9 + static_cast<double>(s) / (kRate * (1 + ppm * 1e-6)) * 1e9;
    out.push_back({s, {std::llround(time + late_ns * random.uniform())}, 0});
  }
  return out;
}

TEST(ASoundClock, FindsTheDriftOfTenMinutesToAHundredthPpm) {
  const std::vector<SoundStamp> stamps = stamped(600, 50, 0);
  const SoundClock clock(stamps, kRate, stamps.back().sample + kPeriod);
  ASSERT_THAT(clock.runs(), SizeIs(1));
  EXPECT_NEAR(clock.runs()[0].ppm, 50, 0.01);
  EXPECT_NEAR(static_cast<double>(clock.time_of(stamps.back().sample)->ns - stamps.back().time.ns), 0, 2000);
}

TEST(ASoundClock, IsNotBentByLateStamps) {
  std::vector<SoundStamp> stamps = stamped(600, -30, 200e3);
  // A recorder that was not scheduled for a tenth of a second, now and then, and most at the end.
  for (std::size_t i = 0; i < stamps.size(); ++i)
    if (i % 50 == 7 || i + 20 > stamps.size())
      stamps[i].time.ns += 100'000'000 + static_cast<std::int64_t>(i);
  for (std::size_t i = 1; i < stamps.size(); ++i)
    stamps[i].time.ns = std::max(stamps[i].time.ns, stamps[i - 1].time.ns + 1);
  const SoundClock clock(stamps, kRate, stamps.back().sample + kPeriod);
  EXPECT_NEAR(clock.runs()[0].ppm, -30, 0.5);
  EXPECT_NEAR(static_cast<double>(clock.time_of(0)->ns), 5e9, 0.5e6);
}

TEST(ASoundClock, BelievesItsRateUntilItHasSeenMore) {
  // A tenth of a second with a millisecond of jitter would say thousands of ppm.
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const std::vector<SoundStamp> stamps = stamped(0.1, 0, 1e6, seed);
    EXPECT_LT(std::abs(SoundClock(stamps, kRate, 4800).runs()[0].ppm), 20);
  }
  const SoundClock one({{0, {7}, 0}}, kRate, 4800);
  EXPECT_EQ(one.runs()[0].ppm, 0);
  EXPECT_EQ(*one.time_of(4800), Timestamp{100'000'007});
}

TEST(ASoundClock, HasALineForEachRun) {
  const std::vector<SoundStamp> stamps = {
      {0, {0}, 0}, {48'000, {1'000'000'000}, 0}, {96'000, {9'000'000'000}, 1}};
  const SoundClock clock(stamps, kRate, 144'000);
  ASSERT_THAT(clock.runs(), SizeIs(2));
  EXPECT_EQ(clock.runs()[0].end, 96'000);
  EXPECT_EQ(*clock.time_of(72'000), Timestamp{1'500'000'000});
  EXPECT_EQ(*clock.time_of(120'000), Timestamp{9'500'000'000});
  EXPECT_EQ(clock.end_of(clock.runs()[1]), Timestamp{10'000'000'000});
  EXPECT_DOUBLE_EQ(clock.sample_at(clock.runs()[1], {9'250'000'000}), 108'000);
}

TEST(ASoundClock, LeavesOutWhatHasNoSamples) {
  const std::vector<SoundStamp> stamps = {
      {0, {0}, 0}, {48'000, {1'000'000'000}, 0}, {96'000, {9'000'000'000}, 1}};
  EXPECT_THAT(SoundClock(stamps, kRate, 50'000).runs(), SizeIs(1));
  EXPECT_THAT(SoundClock({}, kRate, 50'000).runs(), SizeIs(0));
  EXPECT_FALSE(SoundClock().time_of(0));
}

}  // namespace
}  // namespace floatstage::capture
