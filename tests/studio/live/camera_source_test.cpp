#include "studio/live/camera_source.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include <gmock/gmock.h>

#include "capture/take.h"
#include "core/text.h"
#include "studio/live/live_chain.h"
#include "studio/messages/clock.h"
#include "tests/support/small_take.h"

namespace floatstage::studio {
namespace {

// Six cameras of the embedded studio that run at their own pace, and the rig of a take that they made. They
// hold eight pictures, so that even the slowest machine loses none.
class CamerasOfAStudio : public testing::Test {
 protected:
  CamerasOfAStudio() : rig_(small_take(folder_, 1) / "rig.json") {}

  CaptureConfig config() const {
    CaptureConfig config;
    config.frame_rate = kRate;
    config.recorder.take.frame_rate = kRate;
    config.recorder.take.codec = capture::TakeCodec::Raw;
    config.folder = folder_ / "recorded";
    config.rig = rig_;
    for (int i = 0; i < 6; ++i)
      config.cameras.push_back(
          {text("cam0", i), text("synthetic:camera=", i, "&cameras=6&width=160&height=120&samples=4&rate=",
                                 kRate, "&frames=8&live=on")});
    return config;
  }

  static constexpr int kRate = 1;
  TempFolder folder_;
  const std::filesystem::path rig_;
};

TEST_F(CamerasOfAStudio, ArriveInTheOrderOfTheRigUntilTheyAreStopped) {
  CaptureConfig two = config();
  two.cameras = {two.cameras[4], two.cameras[1]};
  Result<std::unique_ptr<CameraSource>> source = CameraSource::open(std::move(two), {});
  ASSERT_THAT(source, IsOk());
  ASSERT_EQ((*source)->rig().cameras.size(), 2U);
  EXPECT_EQ((*source)->rig().cameras[0].serial, "cam04");
  EXPECT_EQ((*source)->frame_rate(), kRate);
  const std::vector<matting::KeySamples> samples = (*source)->samples();
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[1].pictures.at(0).width, 160);

  std::atomic<int> seen[2] = {0, 0};
  (*source)->begin([&](const Frame& frame, Timestamp produced) {
    EXPECT_GE(produced, frame.info.exposure_start);
    ++seen[frame.info.camera];
    seen[frame.info.camera].notify_one();
  });
  for (auto& count : seen)
    for (int before = count; before < 2; before = count) count.wait(before);
  EXPECT_FALSE((*source)->over());
  (*source)->stop();
  const int at_the_end = seen[0];
  EXPECT_TRUE((*source)->over());
  EXPECT_EQ(seen[0], at_the_end);
}

TEST_F(CamerasOfAStudio, TellWhenAPictureWasProducedAndNotWhenSomebodyHadTimeForIt) {
  CaptureConfig one = config();
  one.cameras = {
      {"cam00", "synthetic:camera=0&cameras=6&width=32&height=24&samples=1&rate=50&loop=2&live=on"}};
  Result<std::unique_ptr<CameraSource>> source = CameraSource::open(std::move(one), {});
  ASSERT_THAT(source, IsOk());
  std::atomic<int> seen = 0;
  (*source)->begin([&](const Frame& frame, Timestamp produced) {
    EXPECT_EQ(produced, frame.info.exposure_start);
    // As a writer whose disk is slow: the next pictures wait in the camera meanwhile.
    if (seen == 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    ++seen;
    seen.notify_one();
  });
  for (int before = seen; before < 5; before = seen) seen.wait(before);
  (*source)->stop();
}

TEST_F(CamerasOfAStudio, BecomeASceneThatIsRecordedMeanwhile) {
  Result<std::unique_ptr<CameraSource>> source = CameraSource::open(config(), {});
  ASSERT_THAT(source, IsOk());
  // These cameras are programs: on a busy machine they are late, and a scene needs them all.
  Result<std::unique_ptr<LiveChain>> chain =
      LiveChain::make(**source, {.longest_wait = milliseconds(30'000)});
  ASSERT_THAT(chain, IsOk());
  StudioControl* control = (*source)->control();
  ASSERT_NE(control, nullptr);
  (*chain)->begin();
  const Result<std::string> take = control->start_recording("rehearsal");
  ASSERT_THAT(take, IsOk());
  // The first instant may be one that a camera was not there for yet.
  std::shared_ptr<const LiveScene> scene;
  const auto all_known = [&] {
    return std::all_of(scene->views.begin(), scene->views.end(), [](const auto& v) { return v && v->known; });
  };
  do {
    scene = (*chain)->newest(now() + milliseconds(60'000));
    ASSERT_NE(scene, nullptr) << (*chain)->remark();
  } while (!all_known());
  EXPECT_EQ(scene->views.size(), 6U);
  EXPECT_GT(scene->scene.mesh.triangles.size(), 100U) << (*chain)->remark();
  ASSERT_THAT(control->stop_recording(), IsOk());
  EXPECT_EQ(control->status().cameras.size(), 6U);
  (*chain)->end();

  const Result<std::unique_ptr<capture::TakeReader>> reader =
      capture::TakeReader::open(folder_ / "recorded" / *take);
  ASSERT_THAT(reader, IsOk());
  EXPECT_TRUE((*reader)->manifest().complete);
  EXPECT_GT((*reader)->frame_count(), 0);
}

TEST_F(CamerasOfAStudio, AreNotWaitedForLongerThanSomebodyHasPatience) {
  CaptureConfig one = config();
  one.cameras = {
      {"cam00", "synthetic:camera=0&cameras=6&width=32&height=24&samples=1&rate=0.001&loop=1&live=on"}};
  const Timestamp begun = now();
  EXPECT_THAT(CameraSource::open(std::move(one), {}, {}, milliseconds(500)),
              FailsWith(ErrorCode::Timeout, "camera 'cam00' delivers no picture"));
  EXPECT_LT(seconds(now() - begun), 5);
}

TEST_F(CamerasOfAStudio, NeedARigThatHasThemAll) {
  CaptureConfig without = config();
  without.rig.clear();
  EXPECT_THAT(CameraSource::open(std::move(without), {}),
              FailsWith(ErrorCode::InvalidArgument, "rig = \"rig.json\""));
  CaptureConfig stranger = config();
  stranger.cameras[2].serial = "cam77";
  EXPECT_THAT(CameraSource::open(std::move(stranger), {}), FailsWith(ErrorCode::NotFound, "cam77"));
  CaptureConfig lost = config();
  lost.rig = folder_ / "no-such-rig.json";
  EXPECT_THAT(CameraSource::open(std::move(lost), {}), FailsWith(ErrorCode::NotFound, "no-such-rig.json"));
}

}  // namespace
}  // namespace floatstage::studio
