#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/flags.h"
#include "calib/board.h"
#include "calib/target_sheet.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct TargetArguments {
  std::vector<std::string> words;
  std::filesystem::path out, json;
};

Result<void> run_target(const TargetArguments& given) {
  std::string line;
  for (const std::string& word : given.words) line += (line.empty() ? "" : " ") + word;
  const Result<calib::TargetDesign> target = calib::parse_target(line);
  if (!target) return forward(target);
  const Result<std::vector<std::filesystem::path>> files = calib::write_sheets(*target, given.out);
  if (!files) return forward(files);
  for (const std::filesystem::path& file : *files) std::printf("%s\n", file.string().c_str());
  std::printf("%s\nprint at 100 %% and measure the ruler\n", calib::to_text(*target).c_str());
  if (const std::optional<std::string> warning = calib::ambiguity(*target))
    std::fprintf(stderr, "floatstage: %s\n", warning->c_str());
  if (given.json.empty()) return {};
  nlohmann::json sheets = nlohmann::json::array();
  for (const std::filesystem::path& file : *files) sheets.push_back(file.string());
  return pipeline::save_json({{"target", to_text(*target)}, {"sheets", sheets}}, given.json);
}

}  // namespace

void add_calibrate_target(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<TargetArguments>();
  CLI::App* verb = add_verb(
      calibrate, chosen, "target", "Prints a calibration target, true to scale, to PDF or SVG",
      {"floatstage calibrate target charuco columns=5 rows=7 square=40mm marker=30mm dictionary=5x5_100 -o "
       "board.pdf",
       "floatstage calibrate target chessboard columns=8 rows=5 square=30mm -o board.svg"});
  verb->add_option("words", options->words,
                   "The target: 'chessboard columns=8 rows=5 square=30mm', 'charuco columns=5 rows=7 "
                   "square=40mm marker=30mm dictionary=5x5_100 [inverted]', 'apriltags columns=6 rows=6 "
                   "tag=88mm gap=26.4mm', 'two-sided … thickness=5mm', 'wand positions=0mm,150mm,450mm "
                   "ball=25mm' or '… tag=40mm dictionary=4x4_50'")
      ->required();
  add_out(*verb, options->out, "The .pdf or .svg to write")->required();
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_target(*options); }; });
}

}  // namespace floatstage::apps
