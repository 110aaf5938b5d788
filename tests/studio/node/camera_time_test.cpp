#include "studio/node/camera_time.h"

#include <gtest/gtest.h>

namespace floatstage::studio {
namespace {

constexpr Timestamp at_ms(std::int64_t ms) { return Timestamp{} + milliseconds(ms); }

constexpr std::int64_t kUtc = 1'750'000'000'000;  // ms
constexpr std::int64_t kTai = kUtc + 37'000;      // the network's clock counts leap seconds
constexpr std::int64_t kUptime = 5'000'000;

TEST(CameraTime, LeavesExposuresOnTheMonotonicClockAsTheyAre) {
  CameraTime time;
  EXPECT_EQ(time.to_monotonic(at_ms(1000), at_ms(1030)), at_ms(1000));
  EXPECT_EQ(time.to_system(at_ms(kUtc), at_ms(1030)), milliseconds(kUtc - 1030));
}

TEST(CameraTime, BringsTheNetworksTimeToTheMonotonicClockByTheQuickestPicture) {
  CameraTime time;
  EXPECT_EQ(time.to_monotonic(at_ms(kTai), at_ms(kUptime + 30)), at_ms(kUptime + 30));
  EXPECT_EQ(time.to_monotonic(at_ms(kTai + 40), at_ms(kUptime + 40 + 12)), at_ms(kUptime + 40 + 12))
      << "quicker";
  const Timestamp late = time.to_monotonic(at_ms(kTai + 80), at_ms(kUptime + 80 + 200));
  EXPECT_EQ(late, at_ms(kUptime + 80 + 12) + Nanoseconds{1000}) << "a late picture was exposed no later";
}

TEST(CameraTime, TellsExposuresOfTwoNodesAlikeWhateverTheirPicturesTake) {
  CameraTime quick, slow;
  const Timestamp here = quick.to_monotonic(at_ms(kTai), at_ms(kUptime + 5));
  const Timestamp there = slow.to_monotonic(at_ms(kTai), at_ms(70'000 + 90));  // another uptime
  EXPECT_EQ(here + quick.to_system(at_ms(kUtc + 10), at_ms(kUptime + 10)),
            there + slow.to_system(at_ms(kUtc + 100), at_ms(70'000 + 100)));
  EXPECT_EQ(here + quick.to_system(at_ms(kUtc + 10), at_ms(kUptime + 10)), at_ms(kUtc));
}

TEST(CameraTime, CountsLatencyFromTheExposureHoweverLateSomebodyFetchesThePicture) {
  CameraTime time;
  EXPECT_EQ(time.produced(at_ms(1000), at_ms(1030)), at_ms(1000));
  EXPECT_EQ(time.produced(at_ms(1040), at_ms(1900)), at_ms(1040)) << "fetched late";
  EXPECT_EQ(time.produced(at_ms(1080), at_ms(1079)), at_ms(1079)) << "nothing is fetched before it is there";
  CameraTime network;
  network.produced(at_ms(kTai), at_ms(kUptime + 10));
  EXPECT_EQ(network.produced(at_ms(kTai + 40), at_ms(kUptime + 900)),
            at_ms(kUptime + 50) + Nanoseconds{1000});
}

TEST(CameraTime, FollowsAClockThatDriftsAndForgetsOneThatWasChanged) {
  CameraTime time;
  Timestamp last;
  for (int i = 0; i < 1000; ++i)  // the machine gains 20 ppm on the network
    last = time.to_monotonic(at_ms(kTai + 40 * i), at_ms(kUptime + 40 * i + 10) + Nanoseconds{800 * i});
  EXPECT_EQ(last, at_ms(kUptime + 40 * 999 + 10) + Nanoseconds{800 * 999});
  EXPECT_EQ(time.to_monotonic(at_ms(kTai + 86'400'000), at_ms(kUptime + 50'000)), at_ms(kUptime + 50'000));
  EXPECT_EQ(time.to_monotonic(at_ms(kUptime + 60'000), at_ms(kUptime + 60'010)), at_ms(kUptime + 60'000));
}

}  // namespace
}  // namespace floatstage::studio
