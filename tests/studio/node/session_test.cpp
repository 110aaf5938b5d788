#include <atomic>
#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/take.h"
#include "core/text.h"
#include "studio/node/capture_node.h"
#include "studio/node/capture_session.h"
#include "tests/capture/fake_gige_camera.h"
#include "tests/capture/gige_features.h"
#include "tests/support/matchers.h"
#include "tests/support/own_network.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kSynthetic = "synthetic:cameras=2&width=32&height=24&samples=1&rate=25&frames=";

CaptureConfig config_of(std::vector<CaptureConfig::Camera> cameras, double rate) {
  CaptureConfig config;
  config.frame_rate = rate;
  config.recorder.take.frame_rate = rate;
  config.recorder.take.codec = capture::TakeCodec::Raw;
  config.cameras = std::move(cameras);
  return config;
}

bool never() { return false; }
void silent(const CaptureReport&) {}

std::size_t gaps(const capture::TakeReader& take, int camera) {
  std::size_t count = 0;
  for (const FrameRow& row : take.rows(camera)) count += row.media_index ? 0 : 1;
  return count;
}

TEST(CaptureSession, RecordsEverySourceToItsEnd) {
  const TempFolder folder;
  const CaptureConfig config = config_of(
      {{"a", text(kSynthetic, "10&camera=0")}, {"b", text(kSynthetic, "10&camera=1&dropped=0.3&seed=4")}},
      25);
  CaptureOptions options;
  options.record = true;
  options.take = folder / "take";
  const Result<CaptureReport> report = run_capture(config, options, never, silent);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->cameras[0].stats.delivered, 10u);
  ASSERT_TRUE(report->recording.has_value());
  EXPECT_EQ(report->recording->cameras[0].recorded, 10u);
  EXPECT_EQ(report->recording->cameras[1].recorded, report->cameras[1].stats.delivered);
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder / "take");
  ASSERT_THAT(take, IsOk());
  EXPECT_TRUE((*take)->manifest().complete);
  EXPECT_EQ((*take)->rig().cameras[1].serial, "b");
  EXPECT_EQ(gaps(**take, 1), report->recording->cameras[1].skips);
}

TEST(CaptureSession, StopsWhenAsked) {
  const CaptureConfig config = config_of({{"a", text(kSynthetic, "0")}}, 25);
  std::atomic<bool> streams = false;
  const Result<CaptureReport> report = run_capture(
      config, {}, [&] { return streams.load(); },
      [&](const CaptureReport& seen) { streams = seen.cameras[0].stats.delivered > 0; });
  ASSERT_THAT(report, IsOk());
  EXPECT_FALSE(report->recording.has_value());
  EXPECT_GT(report->cameras[0].stats.delivered, 0u);
}

TEST(CaptureSession, StopsWhileItsCamerasStart) {
  const CaptureConfig config =
      config_of({{"a", "synthetic:width=1600&height=1200&samples=1024&live=on"}}, 25);
  const auto begun = std::chrono::steady_clock::now();
  const auto enough = [&] { return std::chrono::steady_clock::now() - begun > std::chrono::seconds(1); };
  const Result<CaptureReport> report = run_capture(config, {}, enough, silent);
  ASSERT_THAT(report, IsOk());
  EXPECT_TRUE(report->cameras.empty());
  const TempFolder folder;
  CaptureOptions recording;
  recording.record = true;
  recording.take = folder / "take";
  EXPECT_THAT(run_capture(config, recording, enough, silent),
              FailsWith(ErrorCode::Cancelled, "interrupted while the cameras were started"));
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(CaptureSession, RefusesACameraThatDoesNotStart) {
  EXPECT_THAT(run_capture(config_of({{"a", "v4l2:/dev/video77"}}, 25), {}, never, silent),
              FailsWith(ErrorCode::NotFound, "/dev/video77"));
  EXPECT_THAT(run_capture(config_of({{"a", "radio:3"}}, 25), {}, never, silent),
              FailsWith(ErrorCode::InvalidArgument, "radio:3"));
}

TEST(CaptureSession, RefusesCamerasOfTwoClocks) {
  ASSERT_TRUE(enter_own_network());
  ASSERT_TRUE(add_loopback_address(2));
  const TempFolder folder;
  const auto description = capture::described_with(capture::ptp_features("Enable"), folder);
  const capture::FakeGigeCamera left(1, "LEFT", 0, description), right(2, "RIGHT", 0, description);
  const auto both = [&](const char* of_left, const char* of_right) {
    return CaptureNode::open(config_of({{"LEFT", left.uri(of_left)}, {"RIGHT", right.uri(of_right)}}, 20));
  };
  EXPECT_THAT(
      both("ptp=on", "ptp=off"),
      FailsWith(ErrorCode::InvalidArgument,
                "camera 'LEFT' follows the network's clock and 'RIGHT' does not; set ptp=on for all"));
  EXPECT_THAT(both("ptp=off", "ptp=on"), FailsWith(ErrorCode::InvalidArgument, "camera 'RIGHT' follows"));
  EXPECT_THAT(both("ptp=on", "ptp=on"), IsOk());
}

TEST(CaptureSession, LeavesExactlyAsManyGapsAsPicturesFailed) {
  ASSERT_TRUE(enter_own_network());
  const TempFolder folder;
  std::vector<std::unique_ptr<capture::FakeGigeCamera>> devices;
  std::vector<CaptureConfig::Camera> cameras;
  for (int n = 1; n <= 3; ++n) {
    ASSERT_TRUE(n == 1 || add_loopback_address(n));
    const std::string serial = "FAKE" + std::to_string(n);
    // 1 of 1000 packets is never sent, and a picture has 228.
    devices.push_back(std::make_unique<capture::FakeGigeCamera>(n, serial, n == 1 ? 0 : 1));
    cameras.push_back({serial, devices.back()->uri("format=gray8&width=640&height=480&rate=8&resend=off")});
  }
  // Slow enough that a fake camera which waits for the processor is late by less than a row.
  CaptureOptions options;
  options.record = true;
  options.take = folder / "take";
  bool done = false;
  const Result<CaptureReport> report = run_capture(
      config_of(cameras, 8), options, [&] { return done; },
      [&](const CaptureReport& seen) { done = seen.recording->cameras[2].recorded > 50; });
  ASSERT_THAT(report, IsOk());
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder / "take");
  ASSERT_THAT(take, IsOk());
  std::uint64_t failed = 0;
  for (int i = 0; i < 3; ++i) {
    const capture::RecordedCamera& camera = report->recording->cameras[static_cast<std::size_t>(i)];
    // A fake camera that the machine does not let run skips an exposure, which is no failure of the link.
    EXPECT_EQ(gaps(**take, i), camera.lost + camera.unexposed) << camera.serial;
    EXPECT_EQ(camera.lost, camera.failed) << camera.serial;
    EXPECT_EQ((*take)->rows(i).size(), (*take)->rows(0).size()) << camera.serial;
    EXPECT_EQ(camera.recorded + camera.skips, (*take)->rows(0).size()) << camera.serial;
    // One that is late by most of a row exposes twice in the next, and its own stays empty.
    EXPECT_LE(camera.duplicates, camera.unexposed) << camera.serial;
    EXPECT_TRUE((*take)->rows(i).front().media_index && (*take)->rows(i).back().media_index) << camera.serial;
    failed += camera.failed;
  }
  EXPECT_GT(failed, 0u);
  EXPECT_EQ(report->recording->cameras[0].failed, 0u);
}

TEST(CaptureSession, GoesOnWithTheOthersAndTakesACameraBack) {
  ASSERT_TRUE(enter_own_network());
  ASSERT_TRUE(add_loopback_address(2));
  const TempFolder folder;
  capture::FakeGigeCamera steady(1, "STEADY");
  auto shaky = std::make_unique<capture::FakeGigeCamera>(2, "SHAKY");
  const char* options_of_both = "format=gray8&width=64&height=48&rate=20&packet-socket=off";
  const CaptureConfig config =
      config_of({{"STEADY", steady.uri(options_of_both)}, {"SHAKY", shaky->uri(options_of_both)}}, 20);
  CaptureOptions options;
  options.record = true;
  options.take = folder / "take";
  options.seconds = 60;
  // Pulled after the first second's report, plugged in when its loss was seen, stopped when it is back.
  enum { Streaming, Pulled, Back } state = Streaming;
  bool done = false;
  const Result<CaptureReport> report = run_capture(
      config, options, [&] { return done; },
      [&](const CaptureReport& seen) {
        if (state == Streaming && seen.cameras[1].stats.delivered > 5) {
          shaky->kill();
          state = Pulled;
        } else if (state == Pulled && !seen.cameras[1].trouble.empty()) {
          shaky = std::make_unique<capture::FakeGigeCamera>(2, "SHAKY");
          state = Back;
        } else if (state == Back) {
          done = seen.cameras[1].reconnects == 1 && seen.cameras[1].trouble.empty();
        }
      });
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->cameras[1].reconnects, 1u);
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder / "take");
  ASSERT_THAT(take, IsOk());
  EXPECT_GT(gaps(**take, 1), 5u) << "what it did not see is rows that say so";
  // Both cameras agree on what an instant is, before and after.
  const auto& steady_rows = (*take)->rows(0);
  const auto& shaky_rows = (*take)->rows(1);
  ASSERT_GT(shaky_rows.size(), 20u);
  const std::size_t last = std::min(steady_rows.size(), shaky_rows.size()) - 1;
  EXPECT_NEAR(seconds(steady_rows[last].info.exposure_start - shaky_rows[last].info.exposure_start), 0, 0.05);
}

}  // namespace
}  // namespace floatstage::studio
