// What the methods must reach on the bunny and on a light field (docs/reproduce.md), in the experiments' own
// scenes. The short form draws few of their views.
#include <map>

#include "core/text.h"
#include "pipeline/reproduce/experiment.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::pipeline {
namespace {

// Of an experiment: a score by the words before it.
using Scored = std::map<std::string, std::map<std::string, double>>;

Scored scored(const Table& table) {
  Scored scores;
  for (const Table::Row& row : table.rows) {
    std::string name;
    for (const std::string& word : row.words) name += (name.empty() ? "" : " ") + word;
    for (std::size_t i = 0; i < row.numbers.size(); ++i) scores[name][table.numbers[i]] = row.numbers[i];
  }
  return scores;
}

class Bars : public testing::Test {
 protected:
  // Skips without the set.
  void lab_with(const char* set, int short_views) {
    FLOATSTAGE_NEEDS_DATA(real_data(set));
    lab_.data = real_data(set).parent_path();
    if (!wants_long_tests()) lab_.most_views = short_views;
  }
  static Scored run(Result<Outcome> (*experiment)(const Lab&), const Lab& lab) {
    const Result<Outcome> outcome = experiment(lab);
    EXPECT_THAT(outcome, IsOk());
    if (!outcome) return {};
    RecordProperty("table", to_markdown(outcome->table));
    return scored(outcome->table);
  }

  Lab lab_;
};

TEST_F(Bars, OfTheBunnyFromNineteenViews) {
  lab_with("stanford-bunny", 12);  // all: it is quick
  if (IsSkipped()) return;
  Scored by = run(run_fig52, lab_);
  EXPECT_GE(by["floating"]["psnr_mask"], by["linear"]["psnr_mask"] + 2.2);
  EXPECT_GE(by["filtered"]["psnr_mask"], by["linear"]["psnr_mask"] - 0.2);
  EXPECT_GE(by["filtered"]["sharpness"], 1.7 * by["band-limited"]["sharpness"]);
  EXPECT_LT(by["band-limited"]["ghosting"], by["filtered"]["ghosting"]);
  EXPECT_LT(by["filtered"]["ghosting"], by["linear"]["ghosting"]);
  for (const auto& [method, scores] : by) {
    if (method == "band-limited") continue;  // it returns what was filtered
    EXPECT_GE(scores.at("at_camera"), 45) << method;
  }
}

TEST_F(Bars, OfALightFieldOfTwentyFiveAndNinePictures) {
  lab_with("lightfield-shop", 1);
  if (IsSkipped()) return;
  Scored by = run(run_fig53, lab_);
  const double slack = wants_long_tests() ? 0.3 : 1.5;  // one view is not the mean of all
  EXPECT_NEAR(by["25 light-field"]["psnr_mask"], 24.2, slack);
  EXPECT_NEAR(by["9 light-field"]["psnr_mask"], 21.4, slack);
  EXPECT_GE(by["25 floating"]["psnr_mask"], wants_long_tests() ? 32.5 : 31);
  EXPECT_GE(by["9 floating"]["psnr_mask"], wants_long_tests() ? 29.4 : 28);
}

}  // namespace
}  // namespace floatstage::pipeline
