#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/frame_source.h"
#include "core/text.h"
#include "tests/capture/fake_gige_camera.h"
#include "tests/support/matchers.h"
#include "tests/support/own_network.h"

namespace floatstage::capture {
namespace {

class AravisSource : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    ASSERT_TRUE(enter_own_network()) << "this system has no network namespaces";
  }

  static std::unique_ptr<FrameSource> opened(const std::string& uri) {
    Result<std::unique_ptr<FrameSource>> source = open_source(uri);
    EXPECT_THAT(source, IsOk());
    return source ? std::move(*source) : nullptr;
  }

  /// The facts of all frames up to the end of the stream, their buffers given back; the test fails on
  /// anything else.
  static std::vector<FrameInfo> play(FrameSource& source) {
    std::vector<FrameInfo> frames;
    for (;;) {
      Result<Frame> frame = source.next(milliseconds(20'000));
      if (!frame) {
        EXPECT_THAT(frame, FailsWith(ErrorCode::EndOfStream, ""));
        return frames;
      }
      frames.push_back(frame->info);
    }
  }
};

TEST_F(AravisSource, StreamsWhatItWasAskedFor) {
  const FakeGigeCamera camera(1, "FAKE1");
  const auto source =
      opened(camera.uri("format=gray8&width=320&height=240&rate=50&exposure-us=4000&frames=20"));
  const Result<StreamInfo> info = source->start();
  ASSERT_THAT(info, IsOk());
  EXPECT_EQ(info->name, "FAKE1");
  EXPECT_EQ(info->layout, packed_layout(PixelFormat::Gray8, 320, 240));
  EXPECT_NEAR(info->frame_rate, 50, 0.1);
  const std::vector<FrameInfo> frames = play(*source);
  ASSERT_EQ(frames.size() + source->stats().lost, 20u);
  ASSERT_GE(frames.size(), 15u);
  for (const FrameInfo& frame : frames) {
    EXPECT_EQ(frame.exposure, Nanoseconds{4'000'000});
    ASSERT_TRUE(frame.device_time.has_value());
  }
  // However late the pictures came, their instants are the device's.
  const auto whole = [](auto from, auto to) { return seconds(to - from); };
  EXPECT_NEAR(whole(frames.front().exposure_start, frames.back().exposure_start),
              whole(*frames.front().device_time, *frames.back().device_time), 0.05);
}

TEST_F(AravisSource, DeliversTheColoursOfTheFormat) {
  const FakeGigeCamera camera(1, "FAKE1");
  for (const PixelFormat format : {PixelFormat::Rgb8, PixelFormat::BayerRggb8}) {
    const auto source = opened(camera.uri(text("format=", name_of(format), "&width=64&height=48&frames=2")));
    const Result<StreamInfo> info = source->start();
    ASSERT_THAT(info, IsOk());
    EXPECT_EQ(info->layout, packed_layout(format, 64, 48));
    const Result<Frame> frame = source->next(milliseconds(20'000));
    ASSERT_THAT(frame, IsOk());
    EXPECT_THAT(to_rgb(*frame), IsOk());
    source->stop();
  }
}

TEST_F(AravisSource, CountsEveryPictureThatDidNotArriveWhole) {
  // 5 of 1000 packets are never sent, and this camera does not send again: most pictures of 228 packets are
  // hit.
  const FakeGigeCamera camera(1, "LOSSY", 5);
  const auto source = opened(camera.uri("format=gray8&width=640&height=480&rate=30&frames=60&resend=off"));
  ASSERT_THAT(source->start(), IsOk());
  const std::vector<FrameInfo> frames = play(*source);
  const SourceStats stats = source->stats();
  EXPECT_EQ(frames.size(), stats.delivered);
  EXPECT_EQ(stats.delivered + stats.lost, 60u);
  EXPECT_GT(stats.lost, 10u);
  for (const FrameInfo& frame : frames) EXPECT_EQ(frame.status, FrameStatus::Ok);
}

TEST_F(AravisSource, KnowsAPictureWhoseLeaderWasLost) {
  // Pictures of five packets: the leader is lost as often as any other, and with it the picture's number.
  const FakeGigeCamera camera(1, "LOSSY", 100);
  const auto source = opened(camera.uri("format=gray8&width=64&height=64&rate=200&frames=400&resend=off"));
  ASSERT_THAT(source->start(), IsOk());
  const std::vector<FrameInfo> frames = play(*source);
  const SourceStats stats = source->stats();
  EXPECT_EQ(stats.delivered + stats.lost, 400u);
  EXPECT_GT(stats.failed, 40u);
  EXPECT_LE(stats.failed, stats.lost + 5) << "without a number, before the first picture or after the last";
  for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_GT(frames[i].sequence, frames[i - 1].sequence);
}

TEST_F(AravisSource, LendsItsBuffersAndStarvesWhenTheyAreKept) {
  const FakeGigeCamera camera(1, "FAKE1");
  const auto source = opened(camera.uri("format=gray8&width=64&height=48&rate=100&buffers=3"));
  ASSERT_THAT(source->start(), IsOk());
  std::vector<Frame> kept;
  for (int i = 0; i < 3; ++i) {
    Result<Frame> frame = source->next(milliseconds(20'000));
    ASSERT_THAT(frame, IsOk());
    kept.push_back(std::move(*frame));
  }
  EXPECT_THAT(source->next(milliseconds(200)), FailsWith(ErrorCode::Timeout, "camera 'FAKE1'"));
  EXPECT_GT(source->stats().starved, 0u);
  kept.clear();
  EXPECT_THAT(source->next(milliseconds(20'000)), IsOk());
  EXPECT_GT(source->stats().lost, 0u) << "what was sent meanwhile is a gap";
}

TEST_F(AravisSource, SaysWhenTheCameraIsGoneAndComesBackWithIt) {
  auto camera = std::make_unique<FakeGigeCamera>(1, "FAKE1");
  const auto source = opened(camera->uri("format=gray8&width=64&height=48&rate=50"));
  ASSERT_THAT(source->start(), IsOk());
  ASSERT_THAT(source->next(milliseconds(20'000)), IsOk());
  camera->kill();
  for (int tries = 0; tries < 60; ++tries) {
    const Result<Frame> frame = source->next(milliseconds(1000));
    if (frame || frame.error().code == ErrorCode::Timeout) continue;
    EXPECT_THAT(frame, FailsWith(ErrorCode::Disconnected, "camera 'FAKE1'"));
    break;
  }
  EXPECT_THAT(source->next(milliseconds(1)), FailsWith(ErrorCode::Disconnected, ""));
  source->stop();
  EXPECT_THAT(source->start(), FailsWith(ErrorCode::NotFound, "camera 'FAKE1'"));
  camera = std::make_unique<FakeGigeCamera>(1, "FAKE1");
  EXPECT_THAT(source->start(), IsOk());
  EXPECT_THAT(source->next(milliseconds(20'000)), IsOk());
}

TEST_F(AravisSource, FindsACameraByItsSerialAlone) {
  const FakeGigeCamera camera(1, "ONLY");
  const auto source = opened("gige:ONLY?width=64&height=48&frames=1&packet-socket=off");
  EXPECT_THAT(source->start(), IsOk());
  const auto other = opened("gige:NOBODY");
  EXPECT_THAT(other->start(), FailsWith(ErrorCode::NotFound, "answering: ONLY"));
}

TEST_F(AravisSource, SaysWhereNobodyAnswersAndStopsAskingWhenItIsTold) {
  const auto nobody = opened("gige:NOBODY?address=127.0.0.77");
  EXPECT_THAT(nobody->start(),
              FailsWith(ErrorCode::NotFound, "nothing answers at 127.0.0.77; check its cable"));
  const auto begun = std::chrono::steady_clock::now();
  nobody->stop_when(
      [&] { return std::chrono::steady_clock::now() - begun > std::chrono::milliseconds(300); });
  EXPECT_THAT(nobody->start(), FailsWith(ErrorCode::Cancelled, "interrupted before it answered"));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(1300));
}

TEST_F(AravisSource, RefusesTheWrongCameraAtAnAddress) {
  ASSERT_TRUE(add_loopback_address(7));
  const FakeGigeCamera camera(7, "SEVEN");
  EXPECT_THAT(opened("gige:EIGHT?address=127.0.0.7")->start(),
              FailsWith(ErrorCode::NotFound, "at 127.0.0.7 is camera 'SEVEN' instead"));
}

TEST_F(AravisSource, RefusesWhatTheCameraCannotDo) {
  const FakeGigeCamera camera(1, "FAKE1");
  EXPECT_THAT(opened(camera.uri("ptp=on"))->start(),
              FailsWith(ErrorCode::Unsupported, "camera 'FAKE1': it has neither PtpEnable nor GevIEEE1588"));
  EXPECT_THAT(opened(camera.uri("format=yuyv"))->start(), FailsWith(ErrorCode::Unsupported, "YUV422_8"));
  EXPECT_THAT(opened(camera.uri("format=gray8&width=2048&height=2048&rate=30&cameras=8"))->start(),
              FailsWith(ErrorCode::InvalidArgument, "Mbit/s"));
}

TEST_F(AravisSource, TakesOnePictureForEachCallWhenTriggeredBySoftware) {
  const FakeGigeCamera camera(1, "FAKE1");
  const auto source = opened(camera.uri("format=gray8&width=64&height=48&trigger=software&frames=3"));
  ASSERT_THAT(source->start(), IsOk());
  EXPECT_EQ(play(*source).size(), 3u);
}

TEST_F(AravisSource, ListensToTheLineThatItIsToldAndRefusesOneThatItHasNot) {
  const FakeGigeCamera camera(1, "FAKE1");
  EXPECT_THAT(opened(camera.uri("format=gray8&width=64&height=48&trigger=Line0"))->start(), IsOk());
  EXPECT_THAT(opened(camera.uri("format=gray8&width=64&height=48&trigger=Line7"))->start(),
              FailsWith(ErrorCode::Unsupported, "camera 'FAKE1': it has no trigger by Line7"));
}

TEST(AravisUri, RefusesOptionsThatMakeNoSense) {
  for (const char* uri :
       {"gige:", "gige:?rate=3", "gige:A?width=640", "gige:A?format=purple", "gige:A?ptp=maybe",
        "gige:A?packet-socket=2", "gige:A?rate=-1", "gige:A?buffers=1", "gige:A?colour=red"})
    EXPECT_THAT(open_source(uri), FailsWith(ErrorCode::InvalidArgument, "gige:<serial>")) << uri;
}

}  // namespace
}  // namespace floatstage::capture
