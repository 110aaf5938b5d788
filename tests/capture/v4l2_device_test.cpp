// What needs no camera; the rest is in v4l2_guest/.

#include "capture/v4l2/v4l2_device.h"

#include <cerrno>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage::capture {
namespace {

using testing::HasSubstr;

TEST(V4l2Device, ExplainsWhyACameraDoesNotStream) {
  EXPECT_THAT(why_not_streaming(ENOSPC), HasSubstr("no space left on device, which is the USB bus"));
  EXPECT_THAT(why_not_streaming(ENOSPC), HasSubstr("another USB controller"));
  EXPECT_THAT(why_not_streaming(EBUSY), HasSubstr("another program"));
  EXPECT_THAT(why_not_streaming(ENODEV), HasSubstr("unplugged"));
  EXPECT_THAT(why_not_streaming(EINVAL), HasSubstr("Invalid argument"));
}

TEST(V4l2Device, RefusesWhatIsNoCamera) {
  EXPECT_THAT(V4l2Device::open("/dev/null"), FailsWith(ErrorCode::Unsupported, "'/dev/null'"));
  EXPECT_THAT(V4l2Device::open("/dev/video77"), FailsWith(ErrorCode::NotFound, "check its cable"));
}

TEST(V4l2Device, NamesControlsInWordsOfACommandLine) {
  EXPECT_EQ(control_word("Exposure Time, Absolute"), "exposure-time-absolute");
  EXPECT_EQ(control_word("  Gain (dB) "), "gain-db");
}

}  // namespace
}  // namespace floatstage::capture
