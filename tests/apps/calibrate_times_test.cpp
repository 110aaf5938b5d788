// Cameras without a trigger, from the verb that measures their instants to the sets that are formed by them.
#include <condition_variable>
#include <mutex>

#include <gmock/gmock.h>

#include "capture/synchronizer.h"
#include "capture/take.h"
#include "capture/time_offsets.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/synthetic/synthetic_studio.h"
#include "studio/live/take_player.h"
#include "tests/apps/verb_runs.h"

namespace floatstage::apps {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr int kCameras = 5, kFrames = 45;
constexpr int kParts = 100;                        // of a frame, that the studio can be asked for
constexpr int kLate[kCameras] = {0, 37, 0, 0, 0};  // so many parts each
constexpr double kRate = 30;

class CalibrateTimes : public VerbRuns {
 protected:
  /// A second and a half of a dance, taken by cameras that stamp their pictures as if they had a trigger.
  static void SetUpTestSuite() {
    recorded_ = new TempFolder;
    const std::filesystem::path out = *recorded_ / "take";
    const Rig rig =
        synthetic_rig({.shape = RigShape::Ring, .cameras = kCameras, .width = 320, .height = 240});
    const Result<SyntheticStudio> studio =
        SyntheticStudio::create(rig, {.seed = 5, .frame_rate = kParts * kRate, .samples = 4});
    ASSERT_THAT(studio, IsOk());
    capture::TakeWriterOptions options;
    options.frame_rate = kRate;
    const Result<std::unique_ptr<capture::TakeWriter>> writer =
        capture::TakeWriter::create(out, rig, options);
    ASSERT_THAT(writer, IsOk());
    std::vector<std::vector<SyntheticShot>> shots(kFrames);
    parallel_for(shots.size(), 0, [&](std::size_t k) {
      for (int c = 0; c < kCameras; ++c)
        shots[k].push_back(studio->shoot(c, kParts * (static_cast<int>(k) + 1) + kLate[c]));
    });
    const TakeLayout layout(out);
    for (int k = 0; k < kFrames; ++k)
      for (int c = 0; c < kCameras; ++c) {
        SyntheticShot& shot = shots[static_cast<std::size_t>(k)][static_cast<std::size_t>(c)];
        shot.frame.info.sequence = static_cast<std::uint64_t>(k);
        shot.frame.info.device_time.reset();
        shot.frame.info.exposure_start = Timestamp{std::llround(k * 1e9 / kRate)};
        ASSERT_THAT((*writer)->write(shot.frame), IsOk());
        const std::filesystem::path matte = layout.matte(rig.cameras[static_cast<std::size_t>(c)].serial, k);
        std::filesystem::create_directories(matte.parent_path());
        ASSERT_THAT(save_png(to_image(shot.matte), matte), IsOk());
      }
    ASSERT_THAT((*writer)->finish(), IsOk());
  }
  static void TearDownTestSuite() { delete recorded_; }

  static std::string take() { return (*recorded_ / "take").string(); }

  static TempFolder* recorded_;
};
TempFolder* CalibrateTimes::recorded_ = nullptr;

/// The sets that `live` would form of the take.
capture::SyncStats sets_of(const std::filesystem::path& take, std::vector<FrameSet>& sets) {
  const auto player = studio::TakePlayer::open(take, {.rate = 2 * kRate});
  EXPECT_THAT(player, IsOk());
  capture::SyncOptions options;
  options.frame_rate = (*player)->frame_rate();
  options.offsets = (*player)->time_offsets();
  Result<capture::Synchronizer> synchronizer = capture::Synchronizer::make(kCameras, options);
  EXPECT_THAT(synchronizer, IsOk());
  std::mutex mutex;
  std::condition_variable arrived;
  std::size_t count = 0;
  (*player)->begin([&](const Frame& frame, Timestamp) {
    const std::lock_guard lock(mutex);
    synchronizer->push(frame);
    ++count;
    arrived.notify_one();
  });
  std::unique_lock lock(mutex);
  EXPECT_TRUE(arrived.wait_for(lock, std::chrono::seconds(30), [&] { return count == kCameras * kFrames; }));
  while (std::optional<FrameSet> set = synchronizer->drain()) sets.push_back(std::move(*set));
  lock.unlock();
  (*player)->stop();
  return synchronizer->stats();
}

TEST_F(CalibrateTimes, KeepTheOffsetsInTheTakeAndLiveFormsItsSetsByThem) {
  std::vector<FrameSet> sets;
  EXPECT_THAT(sets_of(take(), sets).cameras, testing::Each(testing::Field(&capture::CameraSync::missing, 0u)))
      << "by stamps alone all is well";

  ASSERT_THAT(run({"calibrate", "times", take(), "--json", file("report.json")}), IsOk());
  const Result<capture::TimeOffsetFile> kept = capture::load_time_offsets(TakeLayout(take()));
  ASSERT_THAT(kept, IsOk());
  ASSERT_THAT(kept->cameras, SizeIs(kCameras));
  for (std::size_t c = 0; c < kCameras; ++c) {
    ASSERT_TRUE(kept->cameras[c].offset.has_value()) << c << ": " << kept->cameras[c].not_measured;
    const double period = 1e9 / kRate;
    const double frames = static_cast<double>(kept->cameras[c].offset->count) / period,
                 sigma = static_cast<double>(kept->cameras[c].sigma->count) / period;
    EXPECT_LT(sigma, 0.1) << c;
    EXPECT_NEAR(frames, 0.01 * kLate[c], 0.05) << c;
  }

  sets.clear();
  const capture::SyncStats stats = sets_of(take(), sets);
  ASSERT_THAT(sets, Not(IsEmpty()));
  EXPECT_EQ(stats.cameras[1].used, 0u) << "0.37 frames are 6 ms at twice the pace";
  EXPECT_GT(stats.cameras[1].out_of_tolerance, 0u);
  for (const std::size_t c : {0u, 2u, 3u, 4u}) EXPECT_EQ(stats.cameras[c].missing, 0u) << c;
  EXPECT_GT(stats.spread_p50_ms, 0) << "stamps are equal, instants are not";
}

TEST_F(CalibrateTimes, SayWhichCameraLiveWillLeaveOut) {
  ASSERT_THAT(run({"calibrate", "times", take(), "-o", file("times.json"), "--json", file("report.json")}),
              IsOk());
  std::vector<std::string> warnings = report("report.json").at("warnings");
  EXPECT_THAT(warnings,
              Contains(AllOf(HasSubstr("camera 'cam01': its pictures are taken 1"),
                             HasSubstr("ms from the middle of the others', which is more than the 4 ms"),
                             HasSubstr("Trigger the cameras together"))));
  for (const char* other : {"cam00", "cam02", "cam03", "cam04"})
    EXPECT_THAT(warnings, Not(Contains(AllOf(HasSubstr(other), HasSubstr("its pictures are taken")))))
        << other;
}

TEST_F(CalibrateTimes, RefuseFramesThatDoNotFollowOneAnother) {
  EXPECT_THAT(run({"calibrate", "times", take(), "--frames", "0:30:2", "-o", file("times.json")}),
              FailsWith(ErrorCode::InvalidArgument, "without a step"));
  EXPECT_FALSE(std::filesystem::exists(file("times.json")));
}

}  // namespace
}  // namespace floatstage::apps
