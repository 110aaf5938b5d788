// Runs inside the virtual machine: the third vivid has a camera, /dev/video2, that sees what is written to
// its output, /dev/video3, as a device of v4l2loopback does.

#include <cmath>
#include <cstring>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/v4l2-dv-timings.h>
#include <sys/ioctl.h>

#include "capture/frame_source.h"
#include "capture/stream/stream_output.h"
#include "capture/v4l2/v4l2_device.h"
#include "core/file_descriptor.h"
#include "core/text.h"
#include "tests/support/matchers.h"

namespace floatstage::capture {
namespace {

constexpr const char *kCamera = "/dev/video2", *kOutput = "/dev/video3";
constexpr int kWidth = 640, kHeight = 480;

void ask(const FileDescriptor& device, unsigned long request, void* argument, const char* what) {
  ASSERT_EQ(::ioctl(device.get(), request, argument), 0) << what << ": " << std::strerror(errno);
}

void set_control(const FileDescriptor& device, const std::string& word, int value) {
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  std::string words;
  for (; ::ioctl(device.get(), VIDIOC_QUERYCTRL, &query) == 0; query.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
    const std::string offered = control_word(reinterpret_cast<const char*>(query.name));
    words += offered + " ";
    if (offered != word) continue;
    v4l2_control control{query.id, value};
    return ask(device, VIDIOC_S_CTRL, &control, word.c_str());
  }
  FAIL() << "no control " << word << "; there are " << words;
}

// HDMI out, HDMI in, 640x480 at 60, and a cable between them.
void plug() {
  const FileDescriptor in(::open(kCamera, O_RDWR)), out(::open(kOutput, O_RDWR));
  ASSERT_TRUE(in && out);
  int hdmi_out = 1, hdmi_in = 3;
  ask(out, VIDIOC_S_OUTPUT, &hdmi_out, "HDMI out");
  ask(in, VIDIOC_S_INPUT, &hdmi_in, "HDMI in");
  v4l2_dv_timings timings = V4L2_DV_BT_DMT_640X480P60;
  ask(out, VIDIOC_S_DV_TIMINGS, &timings, "timings out");
  ask(in, VIDIOC_S_DV_TIMINGS, &timings, "timings in");
  set_control(in, "loop-video", 1);
}

Image halves() {
  Image rgb(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      rgb.at(x, y)[0] = x < kWidth / 2 ? 200 : 30;
      rgb.at(x, y)[1] = y < kHeight / 2 ? 160 : 60;
      rgb.at(x, y)[2] = 90;
    }
  return rgb;
}

int luma(const Frame& frame, int x, int y) {
  return std::to_integer<int>(
      frame.pixels[static_cast<std::size_t>(y) * frame.layout.stride + static_cast<std::size_t>(x) * 2]);
}

TEST(V4l2Output, IsSeenByTheCameraBehindIt) {
  ASSERT_NO_FATAL_FAILURE(plug());
  const auto stream = StreamOutput::open(text("v4l2:", kOutput),
                                         {.width = kWidth, .height = kHeight, .rate = 10, .stop = {}});
  ASSERT_THAT(stream, IsOk());
  Result<std::unique_ptr<FrameSource>> camera = open_source(text("v4l2:", kCamera, "?format=yuyv"));
  ASSERT_THAT(camera, IsOk());
  const Result<StreamInfo> info = (*camera)->start();
  ASSERT_THAT(info, IsOk());
  ASSERT_EQ(info->layout.width, kWidth);
  ASSERT_EQ(info->layout.height, kHeight);
  const Image shown = halves();
  const auto expected = [&](int x, int y) {  // BT.709, limited range
    const std::uint8_t* p = shown.at(x, y);
    return 16 + 219.0 / 255.0 * (0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]);
  };
  double error = 255;
  for (int i = 0; i < 60 && error > 3; ++i) {
    (*stream)->offer(shown, std::nullopt);
    const Result<Frame> frame = (*camera)->next(milliseconds(10'000));
    ASSERT_THAT(frame, IsOk());
    error = 0;
    for (const int x : {80, 240, 400, 560})
      for (const int y : {200, 280, 400, 440})  // vivid writes its text above
        error = std::max(error, std::abs(luma(*frame, x, y) - expected(x, y)));
  }
  EXPECT_LE(error, 3);
  const StreamReport report = (*stream)->report();
  EXPECT_GT(report.sent, 0u);
  EXPECT_TRUE(report.trouble.empty()) << report.trouble;
}

TEST(V4l2Output, SaysWhatTakesNoPictures) {
  EXPECT_THAT(StreamOutput::open("v4l2:/dev/video0", {}),
              FailsWith(ErrorCode::Unsupported, "it takes no pictures: it is a camera"));
  EXPECT_THAT(StreamOutput::open("v4l2:/dev/video77", {}), FailsWith(ErrorCode::NotFound, "/dev/video77"));
}

}  // namespace
}  // namespace floatstage::capture
