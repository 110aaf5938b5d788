#include "capture/clock_map.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::capture {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

// A camera whose clock began long ago, runs at a rate of its own and delivers after a delay that jitters.
struct Device {
  double ppm = 0;
  std::int64_t began = 3'600 * kSecond;  // device time at studio time 0
  std::int64_t shortest_delay = 2'000'000;

  std::int64_t device_time(std::int64_t studio) const {
    return began + studio - std::llround(ppm * 1e-6 * static_cast<double>(studio));
  }
};

struct Play {
  ClockMap map;
  std::int64_t worst = 0;  // |mapped - true - shortest delay| after the first second
};

Play play(const Device& device, std::int64_t frames, double mean_jitter_ns, std::uint64_t seed = 1) {
  Play played;
  Random random(seed);
  for (std::int64_t i = 0; i < frames; ++i) {
    const std::int64_t exposure = i * kSecond / 30;
    const double jitter = -mean_jitter_ns * std::log(1 - random.uniform());
    const Timestamp arrival{exposure + device.shortest_delay + std::llround(jitter)};
    const Timestamp mapped = played.map.observe({device.device_time(exposure)}, arrival);
    EXPECT_LE(mapped, arrival) << "a picture is not taken after it arrived";
    if (i > 30) played.worst = std::max(played.worst, std::abs(mapped.ns - exposure - device.shortest_delay));
  }
  return played;
}

TEST(ClockMap, KnowsNothingBeforeTheFirstSample) {
  EXPECT_FALSE(ClockMap().map({5}).has_value());
  EXPECT_EQ(ClockMap().fit().samples, 0u);
}

TEST(ClockMap, IsExactWithoutJitterAtAnyRateOfACrystal) {
  for (const double ppm : {-100.0, -3.5, 0.0, 40.0, 100.0}) {
    const Play played = play({.ppm = ppm}, 900, 0);
    EXPECT_LE(played.worst, 2) << ppm << " ppm, in ns";
    EXPECT_NEAR((played.map.fit().rate - 1) * 1e6, ppm, 0.02);
  }
}

TEST(ClockMap, SeesThroughTheJitterOfTheTransport) {
  // 3 ms of jitter in the mean, which is what a loaded switch does to a picture of 1 MB.
  const Play played = play({.ppm = 60}, 3000, 3e6);
  EXPECT_LE(played.worst, 1'500'000);
  const ClockFit fit = played.map.fit();
  EXPECT_NEAR((fit.rate - 1) * 1e6, 60, 25);
  EXPECT_NEAR(static_cast<double>(fit.delay_p50.count), 3e6 * std::log(2), 0.6e6);
  EXPECT_GT(fit.delay_p95, fit.delay_p50);
}

TEST(ClockMap, MapsTimesBetweenAndAfterItsSamples) {
  const Device device{.ppm = 20};
  Play played = play(device, 300, 0);
  for (const std::int64_t studio : {kSecond, 5 * kSecond, 12 * kSecond}) {
    EXPECT_NEAR(static_cast<double>(played.map.map({device.device_time(studio)})->ns),
                static_cast<double>(studio + device.shortest_delay), 3.0);
  }
}

TEST(ClockMap, BeginsAgainWhenTheDeviceWasRestarted) {
  Play played = play({.ppm = 10}, 90, 0);
  const Timestamp arrival{10 * kSecond};
  EXPECT_EQ(played.map.observe({17}, arrival), arrival);
  EXPECT_EQ(played.map.fit().restarts, 1u);
  EXPECT_EQ(played.map.fit().samples, 1u);
}

TEST(ClockMap, BeginsAgainWhenTheDevicesClockWasSetForward) {
  Play played = play({}, 90, 0);
  const Device later{.began = 9'000 * kSecond};
  const Timestamp mapped = played.map.observe({later.device_time(3 * kSecond)}, {3 * kSecond + 2'000'000});
  EXPECT_EQ(mapped.ns, 3 * kSecond + 2'000'000);
  EXPECT_EQ(played.map.fit().restarts, 1u);
}

TEST(ClockMap, TakesAPictureThatWasHeldUpForAMomentAsLateNotAsAStep) {
  Play played = play({}, 90, 0);
  const Device same;
  const Timestamp mapped = played.map.observe({same.device_time(3 * kSecond)}, {3 * kSecond + 400'000'000});
  EXPECT_EQ(mapped.ns, 3 * kSecond + same.shortest_delay);
  EXPECT_EQ(played.map.fit().restarts, 0u);
}

TEST(ClockMap, BelievesNoRateThatNoCrystalHas) {
  ClockMap map;
  map.observe({0}, {50'000'000});
  map.observe({1'000'000}, {2'000'000});  // two samples 1 ms apart say nothing of a rate
  EXPECT_NEAR(map.fit().rate, 1, 301e-6);
}

TEST(ClockMap, HoldsNoMoreThanItsWindow) {
  const Play played = play({}, 5000, 1e6);
  EXPECT_LE(played.map.fit().samples, 601u);
}

TEST(ClockMap, KeepsNanosecondsWhenTheClockCountsFrom1970) {
  Device device{.ppm = 15, .began = 1'790'000'000 * kSecond};
  EXPECT_LE(play(device, 600, 0).worst, 2);
}

}  // namespace
}  // namespace floatstage::capture
