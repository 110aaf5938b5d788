#include "studio/live/take_player.h"

#include <condition_variable>
#include <mutex>

#include <gmock/gmock.h>

#include "capture/time_offsets.h"
#include "core/file.h"
#include "tests/support/small_take.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

/// Plays until `count` frames have come or the take is over.
std::vector<Frame> played(TakePlayer& player, std::size_t count) {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Frame> frames;
  player.begin([&](const Frame& frame, Timestamp) {
    const std::lock_guard lock(mutex);
    frames.push_back(frame);
    changed.notify_one();
  });
  std::unique_lock lock(mutex);
  while (frames.size() < count && !player.over()) changed.wait_for(lock, std::chrono::milliseconds(10));
  lock.unlock();
  player.stop();
  return frames;
}

class ATakePlayer : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    take_ = small_take(*folder_, 3);
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::unique_ptr<TakePlayer> open(const TakePlayerOptions& options) {
    Result<std::unique_ptr<TakePlayer>> player = TakePlayer::open(take_, options);
    EXPECT_THAT(player, IsOk());
    return std::move(*player);
  }
  static TempFolder* folder_;
  static std::filesystem::path take_;
};
TempFolder* ATakePlayer::folder_ = nullptr;
std::filesystem::path ATakePlayer::take_;

TEST_F(ATakePlayer, DeliversEveryFrameOnceInOrderWithItsPixels) {
  for (const std::uint64_t memory : {std::uint64_t{1} << 30, std::uint64_t{0}}) {
    const auto player = open({.rate = 100, .preload_bytes = memory});
    EXPECT_THAT(player->description(),
                HasSubstr(memory > 0 ? "decoded beforehand" : "decoded while it plays"));
    const std::vector<Frame> frames = played(*player, 18);
    ASSERT_THAT(frames, SizeIs(18));
    EXPECT_TRUE(player->over());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_EQ(frames[i].info.camera, static_cast<int>(i % 6));
      const Frame recorded = *player->take().frame(static_cast<int>(i % 6), static_cast<int>(i / 6));
      EXPECT_EQ(to_rgb(frames[i])->pixels, to_rgb(recorded)->pixels);
    }
  }
}

TEST_F(ATakePlayer, MovesTheExposuresToThePresentAtTheChosenRate) {
  const auto player = open({.rate = 100});
  EXPECT_EQ(player->frame_rate(), 100);
  const std::vector<Frame> frames = played(*player, 18);
  ASSERT_THAT(frames, SizeIs(18));
  EXPECT_NEAR(static_cast<double>((frames[17].info.exposure_start - frames[0].info.exposure_start).count),
              2e7, 1e3);
}

TEST_F(ATakePlayer, TellsHowFarStampsAreFromInstantsAtItsOwnPace) {
  const std::filesystem::path file = capture::times_file(TakeLayout(take_));
  const std::string serial = open({.rate = 100})->rig().cameras[2].serial;
  ASSERT_THAT(capture::save_time_offsets(
                  {"silhouettes", {{serial, Nanoseconds{-8'000'000}, Nanoseconds{100}, ""}}}, file),
              IsOk());
  const auto player = open({.rate = 2 * open({})->frame_rate()});
  ASSERT_THAT(player->time_offsets(), SizeIs(6));
  EXPECT_EQ(player->time_offsets()[0], Nanoseconds{0});
  EXPECT_EQ(player->time_offsets()[2], Nanoseconds{-4'000'000});
  ASSERT_THAT(write_file(file, "{"), IsOk());
  EXPECT_THAT(TakePlayer::open(take_, {}), FailsWith(ErrorCode::BadData, "times.json"));
  std::filesystem::remove(file);
}

TEST_F(ATakePlayer, BeginsAnewWithGrowingNumbersAndTimes) {
  const auto player = open({.rate = 100, .loop = true});
  const std::vector<Frame> frames = played(*player, 40);
  ASSERT_GE(frames.size(), 40U);
  for (std::size_t i = 6; i < frames.size(); ++i) {
    EXPECT_GT(frames[i].info.sequence, frames[i - 6].info.sequence);
    EXPECT_GT(frames[i].info.exposure_start, frames[i - 6].info.exposure_start);
  }
  EXPECT_FALSE(player->over());
}

TEST_F(ATakePlayer, KnowsTheCleanPlatesOfItsTake) {
  const auto samples = open({})->samples();
  ASSERT_THAT(samples, SizeIs(6));
  EXPECT_TRUE(samples[0].empty_stage);
  ASSERT_THAT(samples[0].pictures, SizeIs(1));
  EXPECT_EQ(samples[0].pictures[0].width, 160);
}

TEST_F(ATakePlayer, IsNotDecodedToItsEndForSomebodyWhoHasEnough) {
  EXPECT_THAT(TakePlayer::open(take_, {.stop = [] { return true; }}),
              FailsWith(ErrorCode::Cancelled, "interrupted while the take was decoded"));
}

TEST_F(ATakePlayer, SaysWhatIsWrongWithATake) {
  EXPECT_THAT(TakePlayer::open("/no/such/take", {}), FailsWith(ErrorCode::NotFound, "/no/such/take"));
  EXPECT_THAT(TakePlayer::open(take_, {.rate = -1}), FailsWith(ErrorCode::InvalidArgument, "rate"));
}

}  // namespace
}  // namespace floatstage::studio
