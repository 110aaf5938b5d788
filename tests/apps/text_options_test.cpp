#include "apps/terminal/text_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage::apps {
namespace {

using testing::ElementsAre;

TEST(ParseSize, ReadsWidthAndHeight) {
  const Result<std::pair<int, int>> size = parse_size("640x480");
  ASSERT_THAT(size, IsOk());
  EXPECT_EQ(*size, std::pair(640, 480));
}

TEST(ParseSize, SaysHowToWriteASize) {
  for (const char* wrong :
       {"", "640", "640x", "x480", "640x480x3", "-1x5", "0x480", "640X480", "640x480 ", "99999x4", "6.5x4"})
    EXPECT_THAT(parse_size(wrong), FailsWith(ErrorCode::InvalidArgument, "640x480")) << wrong;
}

TEST(ParseFrames, ReadsOneARangeOrARangeWithStep) {
  EXPECT_THAT(*parse_frames("5", 10), ElementsAre(5));
  EXPECT_THAT(*parse_frames("2:5", 10), ElementsAre(2, 3, 4));
  EXPECT_THAT(*parse_frames("2:10:4", 10), ElementsAre(2, 6));
  EXPECT_THAT(*parse_frames("", 3), ElementsAre(0, 1, 2));
}

TEST(ParseFrames, RefusesWhatIsNotInTheTake) {
  for (const char* wrong : {"10", "5:11", "-1", "5:5", "6:5", "1:5:0", "a", "1:b", "1:2:3:4", ":"})
    EXPECT_THAT(parse_frames(wrong, 10), FailsWith(ErrorCode::InvalidArgument, "frames")) << wrong;
  EXPECT_FALSE(parse_frames("", 0)) << "an empty take";
}

TEST(SplitList, LeavesOutEmptyParts) { EXPECT_THAT(split_list("a,,b,"), ElementsAre("a", "b")); }

}  // namespace
}  // namespace floatstage::apps
