#include "pipeline/label_record.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

TEST(LabelRecord, IsTheSameAfterwards) {
  const TempFolder folder;
  const TakeLayout layout(folder.path());
  fs::create_directories(layout.mattes());
  const LabelRecord record{.labels = {"woman", "man"},
                           .drawn = {"man"},
                           .clicks = {{"woman", "cam00", 3, 10.5, 20}},
                           .inputs = "abc",
                           .sums = {{"cam00", {{0, "1"}, {3, "2"}}}},
                           .files = {{"woman", {{"cam00", {{3, "4"}}}}}},
                           .doubts = {{"why", "cam00", 3, 2, "label.png"}}};
  ASSERT_THAT(save_label_record(record, layout), IsOk());
  EXPECT_EQ(*load_label_record(layout), record);
  // Cut off anywhere, it says so.
  const std::string whole = *read_file(layout.label_record());
  for (std::size_t n = 0; n + 2 < whole.size(); n += 7) {
    ASSERT_THAT(write_file(layout.label_record(), whole.substr(0, n)), IsOk());
    EXPECT_THAT(load_label_record(layout), FailsWith(ErrorCode::BadData, "give the labels again")) << n;
  }
}

}  // namespace
}  // namespace floatstage::pipeline
