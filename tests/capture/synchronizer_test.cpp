#include "capture/synchronizer.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/statistics.h"
#include "core/text.h"
#include "tests/support/matchers.h"

namespace floatstage::capture {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Frame frame_at(int camera, std::int64_t ns, FrameStatus status = FrameStatus::Ok) {
  FrameInfo info;
  info.camera = camera;
  info.exposure_start = {ns};
  info.status = status;
  return make_frame(info, Image(1, 1, 1));
}

constexpr std::int64_t kMs = 1'000'000;

Synchronizer synchronizer(int cameras, SyncOptions options = {.frame_rate = 30}) {
  Result<Synchronizer> made = Synchronizer::make(cameras, options);
  EXPECT_THAT(made, IsOk());
  return std::move(*made);
}

std::vector<FrameSet> drained(Synchronizer& sync) {
  std::vector<FrameSet> sets;
  while (std::optional<FrameSet> set = sync.drain()) sets.push_back(std::move(*set));
  return sets;
}

/// "ab-" when cameras 0 and 1 are in the set and camera 2 is not.
std::string members(const FrameSet& set) {
  std::string letters;
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    letters += set.frames[i].empty() ? '-' : static_cast<char>('a' + static_cast<int>(i));
  }
  return letters;
}

std::vector<std::string> members(const std::vector<FrameSet>& sets) {
  std::vector<std::string> all;
  for (const FrameSet& set : sets) all.push_back(members(set));
  return all;
}

/// Three cameras at a rate, each with an offset and jitter, some frames lost.
std::vector<Frame> stream(double rate, int frames, std::int64_t jitter, std::uint64_t seed, double loss = 0) {
  Random random(seed);
  std::vector<Frame> all;
  for (int i = 0; i < frames; ++i) {
    for (int camera = 0; camera < 3; ++camera) {
      const double noise = random.uniform(-1, 1) * static_cast<double>(jitter);
      const bool lost = random.uniform() < loss;
      if (!lost)
        all.push_back(frame_at(camera, static_cast<std::int64_t>(i * 1e9 / rate + noise) + 5'000 * kMs));
    }
  }
  return all;
}

TEST(Synchronizer, RefusesWhatCannotBe) {
  EXPECT_THAT(Synchronizer::make(0, {.frame_rate = 30}), FailsWith(ErrorCode::InvalidArgument, "no camera"));
  EXPECT_THAT(Synchronizer::make(2, {}), FailsWith(ErrorCode::InvalidArgument, "frame rate"));
  EXPECT_THAT(Synchronizer::make(2, {.frame_rate = 100, .tolerance = milliseconds(5)}),
              FailsWith(ErrorCode::InvalidArgument, "half a period, 5 ms"));
}

TEST(Synchronizer, WaitsForEveryCameraBeforeItSettlesAnInstant) {
  Synchronizer sync = synchronizer(2);
  sync.push(frame_at(0, 0));
  EXPECT_FALSE(sync.next({1 * kMs}).has_value());
  sync.push(frame_at(1, 1 * kMs));
  const std::optional<FrameSet> set = sync.next({2 * kMs});
  ASSERT_TRUE(set.has_value());
  EXPECT_EQ(members(*set), "ab");
  EXPECT_FALSE(sync.next({3 * kMs}).has_value());
}

TEST(Synchronizer, GivesUpACameraAfterTheLongestWait) {
  Synchronizer sync = synchronizer(2);
  sync.push(frame_at(0, 0));
  EXPECT_FALSE(sync.next({99 * kMs}).has_value());
  const std::optional<FrameSet> set = sync.next({100 * kMs});
  ASSERT_TRUE(set.has_value());
  EXPECT_EQ(members(*set), "a-");
  sync.push(frame_at(1, 1 * kMs));
  EXPECT_EQ(sync.stats().cameras[1].late, 1u);
  EXPECT_EQ(sync.stats().cameras[1].missing, 1u);
}

TEST(Synchronizer, GroupsByTimeWhateverTheOrderOfArrival) {
  const std::vector<Frame> frames = stream(30, 60, 2 * kMs, 4, /*loss=*/0.05);
  std::vector<std::vector<std::string>> results;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    // Any interleaving that keeps each camera's own order.
    std::vector<std::deque<Frame>> lanes(3);
    for (const Frame& f : frames) lanes[static_cast<std::size_t>(f.info.camera)].push_back(f);
    Random random(seed);
    Synchronizer sync = synchronizer(3);
    std::vector<FrameSet> sets;
    while (std::any_of(lanes.begin(), lanes.end(), [](const auto& l) { return !l.empty(); })) {
      auto& lane = lanes[random.next() % 3];
      if (lane.empty()) continue;
      sync.push(std::move(lane.front()));
      lane.pop_front();
      while (std::optional<FrameSet> set = sync.next({0})) sets.push_back(std::move(*set));
    }
    while (std::optional<FrameSet> set = sync.drain()) sets.push_back(std::move(*set));
    std::vector<std::string> described;
    for (const FrameSet& set : sets) described.push_back(text(members(set), set.time.ns));
    results.push_back(described);
    EXPECT_EQ(described, results.front()) << "interleaving " << seed;
  }
  EXPECT_GE(results.front().size(), 59u);
}

TEST(Synchronizer, NeverPairsACameraOneFrameLate) {
  // Camera 1 begins one frame after camera 0: by arrival they would pair up off by one for ever.
  Synchronizer sync = synchronizer(2);
  for (int i = 0; i < 10; ++i) {
    sync.push(frame_at(0, i * 33'333'333));
    if (i > 0) sync.push(frame_at(1, i * 33'333'333 + 200'000));
  }
  EXPECT_THAT(members(drained(sync)),
              ElementsAre("a-", "ab", "ab", "ab", "ab", "ab", "ab", "ab", "ab", "ab"));
  EXPECT_LT(sync.stats().spread_max_ms, 0.21);
}

TEST(Synchronizer, FollowsARateThatIsNotTheNominalOne) {
  // An hour of 29.97 against a nominal 30 slips by 108 frames when nothing follows.
  Synchronizer sync = synchronizer(3);
  std::size_t sets = 0;
  for (Frame& frame : stream(30 / 1.001, 3600, 1 * kMs, 9)) {
    sync.push(std::move(frame));
    while (std::optional<FrameSet> set = sync.next({0})) {
      ++sets;
      ASSERT_EQ(members(*set), "abc") << "set " << sets;
    }
  }
  sets += drained(sync).size();
  EXPECT_EQ(sets, 3600u);
  EXPECT_EQ(sync.stats().skipped, 0u);
}

TEST(Synchronizer, SkipsInstantsThatNobodySaw) {
  Synchronizer sync = synchronizer(2);
  for (const int i : {0, 1, 2, 30, 31}) {
    for (int camera = 0; camera < 2; ++camera) sync.push(frame_at(camera, i * 33'333'333));
  }
  EXPECT_THAT(members(drained(sync)), ElementsAre("ab", "ab", "ab", "ab", "ab"));
  EXPECT_EQ(sync.stats().skipped, 27u);
}

TEST(Synchronizer, LeavesOutAFrameThatIsOutOfToleranceAndSaysByHowMuch) {
  Synchronizer sync = synchronizer(3);
  for (int i = 0; i < 20; ++i) {
    for (int camera = 0; camera < 3; ++camera) {
      sync.push(frame_at(camera, i * 33'333'333 + (camera == 2 ? 10 * kMs : 0)));
    }
  }
  for (const FrameSet& set : drained(sync)) EXPECT_EQ(members(set), "ab-");
  const SyncStats stats = sync.stats();
  EXPECT_EQ(stats.cameras[2].out_of_tolerance, 20u);
  EXPECT_NEAR(stats.cameras[2].mean_offset_ms, 10, 0.01);
  EXPECT_THAT(
      sync_complaints(stats, {"left", "right", "top"}, {}),
      ElementsAre(HasSubstr("camera 'top': none of its frames is in any set; its exposures are 10 ms")));
}

TEST(Synchronizer, KeepsTheFrameNearestToTheInstantOfTwo) {
  Synchronizer sync = synchronizer(2);
  sync.push(frame_at(0, 0));
  sync.push(frame_at(1, 1 * kMs));
  sync.push(frame_at(1, 9 * kMs));
  const std::vector<FrameSet> sets = drained(sync);
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_EQ(sets[0].frames[1].info.exposure_start.ns, 1 * kMs);
  EXPECT_EQ(sync.stats().cameras[1].duplicates, 1u);
}

TEST(Synchronizer, PutsNoLostFrameInASet) {
  Synchronizer sync = synchronizer(1);
  sync.push(frame_at(0, 33'333'333));
  Frame lost;
  lost.info.camera = 0;
  lost.info.status = FrameStatus::Lost;
  sync.push(lost);
  const std::vector<FrameSet> sets = drained(sync);
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_EQ(sets[0].time.ns, 33'333'333);
}

TEST(Synchronizer, GoesOnWithoutACameraThatFroze) {
  Synchronizer sync = synchronizer(2, {.frame_rate = 30, .longest_wait = milliseconds(50)});
  std::vector<std::string> seen;
  for (int i = 0; i < 30; ++i) {
    const std::int64_t now = i * 33'333'333;
    sync.push(frame_at(0, now));
    if (i < 10 || i >= 20) sync.push(frame_at(1, now));
    while (std::optional<FrameSet> set = sync.next({now + 1 * kMs})) seen.push_back(members(*set));
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), "a-"), 10);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), "ab"), 20) << "and takes it back when it wakes";
}

TEST(Synchronizer, MeasuresTheSpreadOfItsSets) {
  Synchronizer sync = synchronizer(2);
  for (int i = 0; i < 10; ++i) {
    sync.push(frame_at(0, i * 33'333'333));
    sync.push(frame_at(1, i * 33'333'333 + (i == 5 ? 3 * kMs : 500'000)));
  }
  EXPECT_EQ(drained(sync).size(), 10u);
  const SyncStats stats = sync.stats();
  EXPECT_NEAR(stats.spread_p50_ms, 0.5, 1e-9);
  EXPECT_NEAR(stats.spread_max_ms, 3, 1e-9);
  EXPECT_THAT(sync_complaints(stats, {"a", "b"}, {.spread_ms = 1}), Contains(HasSubstr("up to 3 ms apart")));
  EXPECT_THAT(sync_complaints(stats, {"a", "b"}, {.spread_ms = 3.1}), IsEmpty());
}

TEST(Synchronizer, MeasuresSpreadsOfAnHourAsOfAMinute) {
  Synchronizer sync = synchronizer(2);
  Random random(3);
  std::vector<double> spreads;
  for (std::int64_t i = 0; i < 108'000; ++i) {
    const auto late = static_cast<std::int64_t>(3e6 * random.uniform() * random.uniform());
    spreads.push_back(static_cast<double>(late) * 1e-6);
    sync.push(frame_at(0, i * 33'333'333));
    sync.push(frame_at(1, i * 33'333'333 + late));
    while (sync.next({0})) {
    }
  }
  drained(sync);
  const SyncStats stats = sync.take_stats();
  EXPECT_EQ(stats.complete, spreads.size());
  EXPECT_NEAR(stats.spread_p50_ms, median(spreads), median(spreads) / 128);
  EXPECT_NEAR(stats.spread_p99_ms, percentile(spreads, 0.99), percentile(spreads, 0.99) / 128);
  EXPECT_NEAR(stats.spread_max_ms, percentile(spreads, 1), 1e-9);
  EXPECT_EQ(sync.stats().spread_max_ms, 0) << "counts from zero";
}

// Stamps say that three cameras are apart by up to half a period, and by their offsets they are not.
TEST(Synchronizer, GroupsByInstantsWhereStampsAreKnownToBeOff) {
  const SyncOptions options{.frame_rate = 30,
                            .offsets = {Nanoseconds{0}, Nanoseconds{-16 * kMs}, Nanoseconds{14 * kMs}}};
  Synchronizer sync = synchronizer(3, options);
  for (int i = 0; i < 40; ++i)
    for (int camera = 0; camera < 3; ++camera) {
      const std::int64_t instant = std::llround(i * 1e9 / 30) + 5'000 * kMs;
      sync.push(frame_at(camera, instant - options.offsets[static_cast<std::size_t>(camera)].count));
    }
  const std::vector<FrameSet> sets = drained(sync);
  ASSERT_EQ(sets.size(), 40u);
  for (const FrameSet& set : sets) {
    EXPECT_EQ(members(set), "abc");
    EXPECT_EQ(set.frames[1].info.exposure_start, (Timestamp{set.time.ns + 16 * kMs}));  // stamps stay
  }
  EXPECT_LT(sync.stats().spread_max_ms, 0.001);
}

TEST(Synchronizer, RefusesOffsetsOfOtherCameras) {
  EXPECT_THAT(Synchronizer::make(3, {.frame_rate = 30, .offsets = {Nanoseconds{0}}}),
              FailsWith(ErrorCode::InvalidArgument, "1 time offsets for 3 cameras"));
}

}  // namespace
}  // namespace floatstage::capture
