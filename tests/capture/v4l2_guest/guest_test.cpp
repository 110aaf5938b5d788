// Runs inside the virtual machine, where /dev/video0 is the kernel's test camera vivid. See v4l2_test.cpp.

#include <cstdlib>
#include <fstream>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/frame_source.h"
#include "capture/take.h"
#include "capture/v4l2/v4l2_device.h"
#include "core/text.h"
#include "tests/capture/frame_source_conformance.h"
#include "tests/capture/v4l2_guest/pixels_hash.h"
#include "tests/support/matchers.h"

namespace floatstage::capture {
namespace {

constexpr const char* kDevice = "/dev/video0";
constexpr const char* kSmall = "width=320&height=180&rate=15";

std::unique_ptr<FrameSource> opened(const std::string& options) {
  Result<std::unique_ptr<FrameSource>> source = open_source(text("v4l2:", kDevice, "?", options));
  EXPECT_THAT(source, IsOk());
  return source ? std::move(*source) : nullptr;
}

/// Turns one of vivid's knobs from outside the stream, as another program would.
void turn(const std::string& control, int value) {
  Result<V4l2Device> device = V4l2Device::open(kDevice);
  ASSERT_THAT(device, IsOk());
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (device->ioctl(VIDIOC_QUERYCTRL, &query) == 0) {
    if (control_word(reinterpret_cast<const char*>(query.name)) == control) {
      v4l2_control set{query.id, value};
      ASSERT_EQ(device->ioctl(VIDIOC_S_CTRL, &set), 0) << control;
      return;
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  FAIL() << "vivid has no control " << control;
}

/// Calls next() until it is not a picture, at most so often.
Result<Frame> until_it_fails(FrameSource& source, int most) {
  for (int i = 0; i < most; ++i) {
    Result<Frame> frame = source.next(milliseconds(10'000));
    if (!frame) return frame;
  }
  return source.next(milliseconds(10'000));
}

INSTANTIATE_TEST_SUITE_P(
    V4l2, FrameSourceConformance,
    testing::Values(SourceUnderTest{
        "v4l2", [](const TempFolder&) { return opened(text("format=gray8&", kSmall, "&frames=4")); }, 4, 0,
        /*live=*/true,
        [](const TempFolder&) {
          // vivid plugs itself in again when its last file is closed.
          return PluggedSource{opened(text("format=gray8&", kSmall)), [] { turn("disconnect", 1); }, [] {}};
        }}),
    [](const auto& tested) { return tested.param.name; });

TEST(V4l2, StreamsEveryFormatThatItOffers) {
  for (const PixelFormat format :
       {PixelFormat::Rgb8, PixelFormat::Yuyv, PixelFormat::Nv12, PixelFormat::Gray8}) {
    const auto source = opened(text("format=", name_of(format), "&", kSmall));
    const Result<StreamInfo> info = source->start();
    ASSERT_THAT(info, IsOk()) << name_of(format);
    EXPECT_EQ(info->layout.format, format);
    EXPECT_EQ(info->layout.width, 320);
    EXPECT_NEAR(info->frame_rate, 15, 0.1);
    const Result<Frame> frame = source->next(milliseconds(10'000));
    ASSERT_THAT(frame, IsOk());
    const Result<Image> rgb = to_rgb(*frame);
    ASSERT_THAT(rgb, IsOk());
    // vivid draws colour bars: black and white are both there.
    const auto [low, high] = std::minmax_element(rgb->pixels.begin(), rgb->pixels.end());
    EXPECT_LT(*low, 40);
    EXPECT_GT(*high, 180);
  }
}

TEST(V4l2, NamesWhatIsOfferedWhenAskedForMore) {
  EXPECT_THAT(opened("format=mjpeg")->start(), FailsWith(ErrorCode::Unsupported, "it offers"));
  EXPECT_THAT(opened("width=321&height=181")->start(), FailsWith(ErrorCode::Unsupported, "320x180"));
  EXPECT_THAT(opened("controls=glow:3")->start(), FailsWith(ErrorCode::Unsupported, "brightness"));
  EXPECT_THAT(opened("controls=brightness:1000")->start(),
              FailsWith(ErrorCode::InvalidArgument, "from 0 to 255"));
  auto nowhere = open_source("v4l2:/dev/video77");
  ASSERT_THAT(nowhere, IsOk());
  EXPECT_THAT((*nowhere)->start(), FailsWith(ErrorCode::NotFound, "camera '/dev/video77'"));
}

TEST(V4l2, SetsControls) {
  const auto mean = [](int brightness) {
    const auto source = opened(text("format=gray8&", kSmall, "&controls=brightness:", brightness));
    EXPECT_THAT(source->start(), IsOk());
    const Result<Frame> frame = source->next(milliseconds(10'000));
    EXPECT_THAT(frame, IsOk());
    double sum = 0;
    for (std::size_t i = 0; i < frame->layout.size_bytes; ++i) sum += std::to_integer<int>(frame->pixels[i]);
    return sum / static_cast<double>(frame->layout.size_bytes);
  };
  EXPECT_GT(mean(200), mean(128) + 20);
  turn("brightness", 128);
}

double mean_of_next(FrameSource& source) {
  const Result<Frame> frame = source.next(milliseconds(10'000));
  EXPECT_THAT(frame, IsOk());
  double sum = 0;
  for (std::size_t i = 0; frame && i < frame->layout.size_bytes; ++i)
    sum += std::to_integer<int>(frame->pixels[i]);
  return frame ? sum / static_cast<double>(frame->layout.size_bytes) : 0;
}

const CameraControl* find(const std::vector<CameraControl>& all, const std::string& name) {
  for (const CameraControl& control : all)
    if (control.name == name) return &control;
  return nullptr;
}

TEST(V4l2, TurnsItsKnobsWhileItStreams) {
  const auto source = opened(text("format=gray8&", kSmall));
  ASSERT_THAT(source->start(), IsOk());
  ASSERT_THAT(source->set_control("brightness", 128), IsOk());
  for (int i = 0; i < 4; ++i) mean_of_next(*source);
  const double before = mean_of_next(*source);
  ASSERT_THAT(source->set_control("brightness", 200), IsOk());
  double after = before;
  for (int i = 0; i < 10 && after <= before + 20; ++i) after = mean_of_next(*source);
  EXPECT_GT(after, before + 20);
  std::vector<CameraControl> all = source->controls();
  ASSERT_NE(find(all, "brightness"), nullptr);
  EXPECT_EQ(find(all, "brightness")->value, 200);
  EXPECT_THAT(source->set_control("brightness", 1000),
              FailsWith(ErrorCode::InvalidArgument,
                        "camera '/dev/video0': brightness = 1000 is out of range; it takes 0 to 255"));
  EXPECT_THAT(source->set_control("brightness", 128), IsOk());
  // A knob that its automatic holds is none until that is off.
  ASSERT_THAT(source->set_control("gain-automatic", 1), IsOk());
  EXPECT_THAT(source->set_control("gain", 7), FailsWith(ErrorCode::NotFound, "no control 'gain'"));
  ASSERT_THAT(source->set_control("gain-automatic", 0), IsOk());
  ASSERT_THAT(source->set_control("gain", 7), IsOk());
  all = source->controls();
  ASSERT_NE(find(all, "gain"), nullptr);
  EXPECT_EQ(find(all, "gain")->value, 7);
  EXPECT_THAT(source->set_control("gain-automatic", 1), IsOk());
}

TEST(V4l2, RecordsThreeHundredPicturesThatTheHostCompares) {
  const std::string out = std::getenv("FLOATSTAGE_GUEST_OUT");
  const auto source = opened(text("format=rgb8&", kSmall, "&buffers=16"));
  ASSERT_THAT(source->start(), IsOk());
  Rig rig;
  rig.cameras.resize(1);
  rig.cameras[0].serial = "vivid";
  rig.cameras[0].model.width = 320;
  rig.cameras[0].model.height = 180;
  rig.cameras[0].model.fx = rig.cameras[0].model.fy = 300;
  TakeWriterOptions options;
  options.codec = TakeCodec::Raw;
  options.frame_rate = 15;
  Result<std::unique_ptr<TakeWriter>> writer = TakeWriter::create(out + "/take", rig, options);
  ASSERT_THAT(writer, IsOk());
  std::ofstream hashes(out + "/hashes.txt");
  Timestamp last{};
  for (int i = 0; i < 300; ++i) {
    Result<Frame> frame = source->next(milliseconds(10'000));
    ASSERT_THAT(frame, IsOk());
    EXPECT_EQ(frame->info.status, FrameStatus::Ok);
    EXPECT_GT(frame->info.exposure_start, last);
    last = frame->info.exposure_start;
    frame->info.camera = 0;
    hashes << frame->info.sequence << ' ' << frame->info.exposure_start.ns << ' ' << pixels_hash(*frame)
           << '\n';
    ASSERT_THAT((*writer)->write(*frame), IsOk());
  }
  ASSERT_THAT((*writer)->finish(), IsOk());
  EXPECT_EQ(source->stats().delivered, 300u);
}

TEST(V4l2, LendsItsBuffersAndGoesOnWhenTheyComeBack) {
  const auto source = opened(text("format=gray8&", kSmall, "&buffers=4"));
  ASSERT_THAT(source->start(), IsOk());
  std::vector<Frame> kept;
  Result<Frame> frame = source->next(milliseconds(10'000));
  while (frame) {
    kept.push_back(std::move(*frame));
    frame = source->next(milliseconds(500));
  }
  EXPECT_THAT(frame, FailsWith(ErrorCode::Timeout, ""));
  EXPECT_GE(kept.size(), 4u);
  const std::uint64_t hash = pixels_hash(kept[0]);
  const Frame first = kept[0];
  kept.clear();
  EXPECT_THAT(source->next(milliseconds(10'000)), IsOk());
  EXPECT_GT(source->stats().starved, 0u);
  source->stop();
  EXPECT_EQ(pixels_hash(first), hash) << "a frame outlives its stream";
  ASSERT_THAT(source->start(), IsOk());
  EXPECT_THAT(source->next(milliseconds(10'000)), IsOk());
}

TEST(V4l2Faults, DroppedBuffersAreGapsAndCounted) {
  turn("percentage-of-dropped-buffers", 40);
  const auto source = opened(text("format=gray8&", kSmall, "&frames=60"));
  ASSERT_THAT(source->start(), IsOk());
  EXPECT_THAT(until_it_fails(*source, 60), FailsWith(ErrorCode::EndOfStream, ""));
  const SourceStats stats = source->stats();
  EXPECT_EQ(stats.delivered + stats.lost, 60u);
  EXPECT_GT(stats.lost, 8u);
  source->stop();
  turn("percentage-of-dropped-buffers", 0);
}

TEST(V4l2Faults, AFlaggedBufferIsCorrupt) {
  const auto source = opened(text("format=gray8&", kSmall));
  ASSERT_THAT(source->start(), IsOk());
  ASSERT_THAT(source->next(milliseconds(10'000)), IsOk());
  turn("inject-v4l2-buf-flag-error", 1);
  bool corrupt = false;
  for (int i = 0; i < 40 && !corrupt; ++i) {
    const Result<Frame> frame = source->next(milliseconds(10'000));
    ASSERT_THAT(frame, IsOk());
    corrupt = frame->info.status == FrameStatus::Corrupt;
  }
  EXPECT_TRUE(corrupt);
  EXPECT_EQ(source->stats().corrupt, 1u);
}

TEST(V4l2Faults, ASequenceThatWrapsGoesOn) {
  turn("wrap-sequence-number", 1);
  const auto source = opened(text("format=gray8&", kSmall));
  ASSERT_THAT(source->start(), IsOk());
  std::uint64_t last = 0;
  for (int i = 0; i < 200; ++i) {
    const Result<Frame> frame = source->next(milliseconds(10'000));
    ASSERT_THAT(frame, IsOk());
    ASSERT_TRUE(i == 0 || frame->info.sequence > last);
    last = frame->info.sequence;
  }
  EXPECT_LT(last, 2000u) << "a wrap is no gap of four thousand million";
  source->stop();
  turn("wrap-sequence-number", 0);
}

TEST(V4l2Faults, TimesThatWrapStayOnTheStudioClock) {
  for (const int kind : {1, 2}) {
    turn("wrap-timestamp", kind);
    const auto source = opened(text("format=gray8&", kSmall));
    ASSERT_THAT(source->start(), IsOk());
    Timestamp last{};
    for (int i = 0; i < 30; ++i) {
      const Result<Frame> frame = source->next(milliseconds(10'000));
      ASSERT_THAT(frame, IsOk());
      ASSERT_GT(frame->info.exposure_start, last);
      EXPECT_TRUE(i == 0 || seconds(frame->info.exposure_start - last) < 20) << "a jump of days";
      last = frame->info.exposure_start;
    }
    source->stop();
    turn("wrap-timestamp", 0);
  }
}

TEST(V4l2Faults, AStampOfTheReadoutsEndIsMovedToTheExposure) {
  std::vector<Nanoseconds> shifts;
  for (const int start_of_exposure : {0, 1}) {
    turn("timestamp-source", start_of_exposure);
    const auto source = opened(text("format=gray8&", kSmall));
    ASSERT_THAT(source->start(), IsOk());
    const Result<Frame> frame = source->next(milliseconds(10'000));
    ASSERT_THAT(frame, IsOk());
    ASSERT_TRUE(frame->info.device_time.has_value());
    shifts.push_back(frame->info.exposure_start - Timestamp{frame->info.device_time->count});
    source->stop();
  }
  EXPECT_NEAR(seconds(shifts[0]), -1.0 / 15, 0.001);
  EXPECT_EQ(shifts[1].count, 0);
  turn("timestamp-source", 0);
}

TEST(V4l2Faults, AnErrorAtTheStartIsSaidAndTheNextStartWorks) {
  for (const char* fault : {"inject-vidioc-reqbufs-error", "inject-vidioc-streamon-error"}) {
    turn(fault, 1);
    const auto source = opened(text("format=gray8&", kSmall));
    EXPECT_THAT(source->start(), FailsWith(ErrorCode::Io, "camera '/dev/video0'")) << fault;
    EXPECT_THAT(source->start(), IsOk()) << fault;
    EXPECT_THAT(source->next(milliseconds(10'000)), IsOk()) << fault;
  }
}

TEST(V4l2Faults, AFatalStreamErrorEndsTheStreamAndAStartHealsIt) {
  const auto source = opened(text("format=gray8&", kSmall));
  ASSERT_THAT(source->start(), IsOk());
  ASSERT_THAT(source->next(milliseconds(10'000)), IsOk());
  turn("inject-fatal-streaming-error", 1);
  EXPECT_THAT(until_it_fails(*source, 40), FailsWith(ErrorCode::Disconnected, "its stream is over"));
  EXPECT_THAT(source->next(milliseconds(1)), FailsWith(ErrorCode::Disconnected, ""));
  source->stop();
  ASSERT_THAT(source->start(), IsOk());
  EXPECT_THAT(source->next(milliseconds(10'000)), IsOk());
}

TEST(V4l2Faults, AnUnpluggedCameraIsGoneUntilItIsBack) {
  const auto source = opened(text("format=gray8&", kSmall));
  ASSERT_THAT(source->start(), IsOk());
  ASSERT_THAT(source->next(milliseconds(10'000)), IsOk());
  turn("disconnect", 1);
  EXPECT_THAT(until_it_fails(*source, 40), FailsWith(ErrorCode::Disconnected, "unplugged"));
  source->stop();
  ASSERT_THAT(source->start(), IsOk()) << "vivid plugs itself in again when its last file is closed";
  EXPECT_THAT(source->next(milliseconds(10'000)), IsOk());
}

}  // namespace
}  // namespace floatstage::capture
