#include "core/log.h"

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/text.h"
#include "core/time.h"

namespace floatstage {
namespace {

TEST(Log, GoesToStandardErrorAndNeverToStandardOutput) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  log::set_level(log::Level::Info);
  log::warning("camera 'left' {} lost 3 frames");
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("camera 'left' {} lost 3 frames"));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(Log, KeepsBelowItsLevelSilent) {
  testing::internal::CaptureStderr();
  log::set_level(log::Level::Warning);
  log::debug("d");
  log::info("i");
  log::error("e");
  log::set_level(log::Level::Off);
  log::error("f");
  log::set_level(log::Level::Info);
  const std::string written = testing::internal::GetCapturedStderr();
  EXPECT_THAT(written, testing::EndsWith(" e\n"));
  EXPECT_EQ(std::count(written.begin(), written.end(), '\n'), 1);
}

TEST(Text, WritesItsPartsOneAfterTheOther) {
  EXPECT_EQ(text("camera ", 3, " of ", 8u, '.'), "camera 3 of 8.");
}

TEST(Time, SubtractsInstantsToSpans) {
  constexpr Timestamp start{1'000}, end{41'000'000};
  static_assert((end - start) + Nanoseconds{1'000} == Nanoseconds{41'000'000});
  EXPECT_EQ(start + (end - start), end);
  EXPECT_EQ(end - milliseconds(41), Timestamp{});
  EXPECT_EQ(milliseconds(40) * 25, milliseconds(1000));
  EXPECT_DOUBLE_EQ(seconds(milliseconds(1500)), 1.5);
  EXPECT_LT(start, end);
}

}  // namespace
}  // namespace floatstage
