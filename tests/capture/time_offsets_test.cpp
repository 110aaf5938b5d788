#include "capture/time_offsets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::ElementsAre;

TimeOffsetFile some() {
  return {"silhouettes",
          {{"left", Nanoseconds{0}, Nanoseconds{0}, ""},
           {"right", Nanoseconds{-12'333'333}, Nanoseconds{400'000}, ""},
           {"top", {}, {}, "nothing moves in its silhouettes"}}};
}

TEST(TimeOffsets, AreReadAsTheyWereWritten) {
  const TempFolder folder;
  ASSERT_THAT(save_time_offsets(some(), folder.path() / "times.json"), IsOk());
  const Result<TimeOffsetFile> read = load_time_offsets(folder.path() / "times.json");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(*read, some());
}

TEST(TimeOffsets, AreZeroForCamerasThatWereNotMeasured) {
  EXPECT_THAT(offsets_of(some(), {"top", "right", "unheard-of"}),
              ElementsAre(Nanoseconds{0}, Nanoseconds{-12'333'333}, Nanoseconds{0}));
}

TEST(TimeOffsets, RefuseWhatIsNoSuchFile) {
  EXPECT_THAT(parse_time_offsets("{}", "t"), FailsWith(ErrorCode::BadData, "floatstage_times"));
  EXPECT_THAT(parse_time_offsets(R"({"floatstage_times": 2, "from": "", "cameras": []})", "t"),
              FailsWith(ErrorCode::Unsupported, "format 2"));
  EXPECT_THAT(
      parse_time_offsets(R"({"floatstage_times": 1, "from": "x", "cameras": [{"serial": "a"}]})", "t"),
      FailsWith(ErrorCode::BadData, "offset_ns"));
  EXPECT_THAT(parse_time_offsets(R"({"floatstage_times": 1, "from": "x", "cameras":
                                     [{"serial": "a", "offset_ns": 1e12, "sigma_ns": 1}]})",
                                 "t"),
              FailsWith(ErrorCode::BadData, "more than a minute"));
  const std::string whole = to_json(some());
  for (std::size_t length = 0; length + 1 < whole.size(); ++length)
    EXPECT_FALSE(parse_time_offsets(whole.substr(0, length), "t")) << length;
}

}  // namespace
}  // namespace floatstage::capture
