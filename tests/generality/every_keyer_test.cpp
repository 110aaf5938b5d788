#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/generality/score_table.h"
#include "tests/support/long_tests.h"
#include "tests/support/places.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

// Every method of matting on every set: what the documented commands give on stages that nobody had in mind.
// The table in docs/generality.md is the bound: the test fails where a cell is worse than it says, and prints
// the row as it is now.
namespace floatstage::generality {
namespace {

constexpr double kSlack =
    0.015;  // the docs' figures are rounded to 0.005, and compilers differ by a few pixels
constexpr double kUsable = 0.85;  // a matte below that, in the mean over cameras, is wrong: it has to be said
constexpr double kLongSlack = 0.05;  // other sizes, other seeds

class EveryKeyer : public testing::TestWithParam<SetName> {
 protected:
  static ScoreTable docs() {
    const auto page = read_file(source_folder() / "docs/generality.md");
    EXPECT_TRUE(page);
    return page ? read_table(*page) : ScoreTable();
  }
};

void expect_as_documented(const std::string& method, const Outcome& outcome, const Cell& stated) {
  const Cell now = cell_of(outcome);
  const double slack = wants_long_tests() ? kLongSlack : kSlack;
  if (stated.has_mattes) {
    ASSERT_TRUE(now.has_mattes) << method << " has no mattes any more: " << outcome.said.front();
    if (stated.mean >= kUsable) {
      EXPECT_GE(now.mean, stated.mean - slack) << method;
      EXPECT_GE(now.worst, stated.worst - 2 * slack) << method << ", camera " << outcome.worst_camera;
    }
  }
  EXPECT_TRUE(now.has_mattes || now.said) << method << " says nothing";
  const bool wrong = now.has_mattes && now.mean < kUsable,
             listed =
                 stated.has_mattes && stated.mean < kUsable && !stated.said;  // a defect that the docs name
  EXPECT_TRUE(!wrong || now.said || listed)
      << method << " is wrong, " << text_of(now) << ", and says nothing";
}

TEST_P(EveryKeyer, GivesWhatTheDocsSay) {
  const SetName& row = GetParam();
  if (!row.data.empty()) FLOATSTAGE_NEEDS_DATA(row.data);
  const ScoreTable stated = docs();
  EXPECT_TRUE(stated.contains(row.name)) << "docs/generality.md has no row '" << row.name << "'";
  const auto cells = stated.contains(row.name) ? stated.at(row.name) : std::map<std::string, Cell>();
  const StageSet set = row.load(wants_long_tests());
  TempFolder folder;
  write_take(set, folder / "take");
  std::string line = "| " + row.name + " |";
  for (const std::string& method : all_methods()) {
    const Outcome outcome = outcome_of(method, set, folder / "take");
    line += " " + text_of(cell_of(outcome)) + " |";
    std::printf("  %s: %d of %d, worst camera %s\n", method.c_str(), outcome.made, outcome.asked,
                outcome.worst_camera.c_str());
    for (const std::string& sentence : outcome.said) std::printf("    %s\n", sentence.c_str());
    std::fflush(stdout);
    EXPECT_TRUE(cells.contains(method)) << "docs/generality.md does not say what '" << method << "' gives";
    if (cells.contains(method)) expect_as_documented(method, outcome, cells.at(method));
  }
  std::printf("%s\n", line.c_str());
}

std::string test_name(const testing::TestParamInfo<SetName>& info) {
  std::string name;
  for (const char c : info.param.name) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(OnEverySet, EveryKeyer, testing::ValuesIn(all_sets()), test_name);

TEST(ScoreTable, IsReadAsItIsWritten) {
  const Cell good{.has_mattes = true, .said = false, .mean = 0.97, .worst = 0.9},
      doubtful{.has_mattes = true, .said = true, .mean = 0.5, .worst = 0.12}, refused{.said = true};
  const ScoreTable read =
      read_table("Text.\n\n| set | a | b | c |\n| --- | --- | --- | --- |\n| s, t | " + text_of(good) +
                 " | " + text_of(doubtful) + " | " + text_of(refused) + " |\n\nMore.\n");
  ASSERT_TRUE(read.contains("s, t"));
  EXPECT_EQ(text_of(read.at("s, t").at("a")), text_of(good));
  EXPECT_EQ(text_of(read.at("s, t").at("b")), text_of(doubtful));
  EXPECT_EQ(text_of(read.at("s, t").at("c")), text_of(refused));
}

}  // namespace
}  // namespace floatstage::generality
