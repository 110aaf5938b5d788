#include "capture/synthetic/synthetic_source.h"

#include <chrono>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "capture/frame_source.h"
#include "core/text.h"
#include "tests/support/matchers.h"

namespace floatstage::capture {
namespace {

constexpr const char* kSmall = "camera=1&cameras=4&width=32&height=24&samples=1&rate=50&live=on";

std::unique_ptr<FrameSource> started(const std::string& options) {
  Result<std::unique_ptr<FrameSource>> source = open_synthetic(options, "synthetic:" + options);
  EXPECT_THAT(source, IsOk());
  EXPECT_THAT((*source)->start(), IsOk());
  return std::move(*source);
}

// What a camera shows, by the time of exposure.
using Shown = std::map<std::int64_t, std::string>;

void look(FrameSource& camera, Shown& shown) {
  const Result<Frame> frame = camera.next(milliseconds(20'000));
  ASSERT_THAT(frame, IsOk());
  shown[frame->info.exposure_start.ns].assign(reinterpret_cast<const char*>(frame->pixels.get()),
                                              frame->layout.size_bytes);
}

TEST(ALiveSyntheticCamera, ShowsThePoseOfTheTimeWheneverItWasStarted) {
  const auto early = started(text(kSmall, "&loop=7"));
  Shown by_early, by_late;
  for (int i = 0; i < 5; ++i) look(*early, by_early);
  const auto late = started(text(kSmall, "&loop=7"));
  int common = 0;
  for (int i = 0; i < 200 && common < 5; ++i) {
    look(*early, by_early);
    look(*late, by_late);
    common = 0;
    for (const auto& [time, picture] : by_late) common += by_early.contains(time) ? 1 : 0;
  }
  ASSERT_GE(common, 5);
  for (const auto& [time, picture] : by_late)
    if (by_early.contains(time)) {
      EXPECT_TRUE(by_early[time] == picture) << "at " << time;
    }
}

// Pictures that take hours to render, until somebody has enough after a tenth of a second.
constexpr const char* kHours = "synthetic:cameras=4&width=1600&height=1200&samples=1024&loop=10000";

class Impatience {
 public:
  void begin() { end_ = std::chrono::steady_clock::now() + std::chrono::milliseconds(100); }
  bool over() const { return std::chrono::steady_clock::now() >= end_; }
  double seconds_since() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - end_).count();
  }

 private:
  std::chrono::steady_clock::time_point end_;
};

TEST(ALiveSyntheticCamera, StopsWithinASecondWhileItRendersItsPictures) {
  Impatience patience;
  Result<std::unique_ptr<FrameSource>> source = open_source(text(kHours, "&live=on"));
  ASSERT_THAT(source, IsOk());
  (*source)->stop_when([&] { return patience.over(); });
  patience.begin();
  EXPECT_THAT((*source)->start(), FailsWith(ErrorCode::Cancelled, "interrupted"));
  EXPECT_LT(patience.seconds_since(), 1);
  EXPECT_THAT((*source)->next(milliseconds(10)), FailsWith(ErrorCode::InvalidArgument, "not started"));
}

TEST(ASyntheticCamera, StopsWithinASecondInTheMiddleOfAPicture) {
  Impatience patience;
  Result<std::unique_ptr<FrameSource>> source = open_source(kHours);
  ASSERT_THAT(source, IsOk());
  ASSERT_THAT((*source)->start(), IsOk());
  (*source)->stop_when([&] { return patience.over(); });
  patience.begin();
  EXPECT_THAT((*source)->next(milliseconds(10)), FailsWith(ErrorCode::Cancelled, "interrupted"));
  EXPECT_LT(patience.seconds_since(), 1);
}

TEST(ALiveSyntheticCamera, ShowsItsFewPosesAgainAndAgain) {
  const auto camera = started(text(kSmall, "&loop=3"));
  Shown shown;
  for (int i = 0; i < 8; ++i) look(*camera, shown);
  const std::int64_t period = 20'000'000;
  int again = 0, next = 0;
  for (const auto& [time, picture] : shown) {
    if (shown.contains(time + 3 * period)) {
      ++again;
      EXPECT_TRUE(shown[time + 3 * period] == picture);
    }
    if (shown.contains(time + period)) {
      ++next;
      EXPECT_FALSE(shown[time + period] == picture) << "the performer moves";
    }
  }
  EXPECT_GT(again, 0);
  EXPECT_GT(next, 0);
}

}  // namespace
}  // namespace floatstage::capture
