#include "studio/node/set_builder.h"

#include <gtest/gtest.h>

#include "studio/messages/clock.h"
#include "tests/support/matchers.h"

namespace floatstage::studio {
namespace {

constexpr std::int64_t kPeriod = 40'000'000;  // ns

std::unique_ptr<SetBuilder> builder(int cameras, Nanoseconds longest_wait = milliseconds(100)) {
  Result<std::unique_ptr<SetBuilder>> made =
      SetBuilder::make(cameras, {.frame_rate = 25, .longest_wait = longest_wait});
  EXPECT_THAT(made, IsOk());
  return std::move(*made);
}

Frame frame(int camera, std::int64_t ns) {
  FrameInfo info;
  info.camera = camera;
  info.exposure_start = {ns};
  return make_frame(info, Image(2, 2, 1));
}

TEST(SetBuilder, GivesAWholeInstantWithTheTimesOfItsDelivery) {
  const auto sets = builder(2);
  const Timestamp t0 = now();
  sets->push(frame(0, t0.ns), t0 + milliseconds(3));
  EXPECT_FALSE(sets->newest({})) << "the second camera is missing yet";
  sets->push(frame(1, t0.ns + 1000), t0 + milliseconds(2));
  const std::optional<TimedSet> set = sets->newest({});
  ASSERT_TRUE(set);
  EXPECT_EQ(set->instant.epoch, 0U);
  EXPECT_EQ(set->produced[0], t0 + milliseconds(3));
  EXPECT_EQ(set->produced[1], t0 + milliseconds(2));
  EXPECT_EQ(set->first_produced, t0 + milliseconds(2));
  EXPECT_FALSE(sets->newest({})) << "once";
}

TEST(SetBuilder, LeavesOutInstantsThatNobodyHadTimeForAndCountsThem) {
  const auto sets = builder(2);
  const Timestamp t0 = now();
  for (int k = 0; k < 5; ++k)
    for (int camera : {0, 1}) sets->push(frame(camera, t0.ns + k * kPeriod), t0 + Nanoseconds{k * kPeriod});
  const std::optional<TimedSet> set = sets->newest({});
  ASSERT_TRUE(set);
  EXPECT_EQ(set->instant.epoch, 4U);
  EXPECT_EQ(set->first_produced, t0 + Nanoseconds{4 * kPeriod}) << "not those of the instants before";
  const SetBuilder::Counters counters = sets->counters();
  EXPECT_EQ(counters.frames, 10U);
  EXPECT_EQ(counters.sets, 5U);
  EXPECT_EQ(counters.overtaken, 4U);
}

TEST(SetBuilder, NumbersInstantsByTimeSoThatALostOneIsAGap) {
  const auto sets = builder(1);
  const Timestamp t0 = now();
  sets->push(frame(0, t0.ns), t0);
  ASSERT_EQ(sets->newest({})->instant.epoch, 0U);
  sets->push(frame(0, t0.ns + 3 * kPeriod), t0);
  EXPECT_EQ(sets->newest({})->instant.epoch, 3U);
}

TEST(SetBuilder, GoesOnWithoutACameraThatIsLate) {
  const auto sets = builder(2, milliseconds(0));
  const Timestamp t0 = now() - milliseconds(1);
  sets->push(frame(1, t0.ns), t0);
  const std::optional<TimedSet> set = sets->newest({});
  ASSERT_TRUE(set);
  EXPECT_TRUE(set->images.frames[0].empty());
  EXPECT_FALSE(set->images.frames[1].empty());
  EXPECT_EQ(sets->counters().sync.incomplete, 1U);
}

TEST(SetBuilder, GivesNothingAfterItWasClosed) {
  const auto sets = builder(1);
  sets->push(frame(0, now().ns), now());
  sets->close();
  EXPECT_FALSE(sets->newest(now() + milliseconds(100'000))) << "and does not wait";
  sets->push(frame(0, now().ns), now());
  EXPECT_EQ(sets->counters().frames, 1U);
}

TEST(SetBuilder, RefusesCamerasWithoutARate) {
  EXPECT_THAT(SetBuilder::make(2, {}), FailsWith(ErrorCode::InvalidArgument, "frame rate"));
}

}  // namespace
}  // namespace floatstage::studio
