#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/take/take_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/derive/undistort_take.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct TakeUndistortArguments {
  pipeline::UndistortOptions undistort;
  std::filesystem::path json;
};

std::string percent(double share) { return text(std::round(1000 * share) / 10, " %"); }

Result<void> run_take_undistort(const TakeUndistortArguments& given) {
  pipeline::UndistortOptions options = given.undistort;
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::UndistortReport> report = pipeline::undistort_take(options);
  if (!report) return forward(report);
  for (const std::string& note : report->notes) log::info(note);
  nlohmann::json cameras = nlohmann::json::array();
  for (const pipeline::StraightenedCamera& c : report->cameras) {
    std::printf("  %-16s %s\n", c.serial.c_str(),
                c.was_straight ? "straight already, as it was"
                               : text(percent(c.kept), " of its photographs shown, ", percent(c.hidden),
                                      " of its straight pictures hidden")
                                     .c_str());
    cameras.push_back(
        {{"serial", c.serial}, {"was_straight", c.was_straight}, {"kept", c.kept}, {"hidden", c.hidden}});
  }
  const auto changed = std::count_if(report->cameras.begin(), report->cameras.end(),
                                     [](const auto& c) { return !c.was_straight; });
  std::printf("%s: %d frames, %ld of %zu cameras straightened\n", options.out.c_str(), report->frames,
              static_cast<long>(changed), report->cameras.size());
  if (given.json.empty()) return {};
  return pipeline::save_json({{"take", options.out.string()},
                              {"from", options.take.string()},
                              {"frames", report->frames},
                              {"cameras", std::move(cameras)},
                              {"notes", report->notes}},
                             given.json);
}

}  // namespace

void add_take_undistort(CLI::App& take, Chosen& chosen) {
  auto options = std::make_shared<TakeUndistortArguments>();
  CLI::App* verb = add_verb(
      take, chosen, "undistort",
      "The same recording with straight pictures, as a new take of cameras without lenses",
      {"floatstage take undistort T -o straight", "floatstage take undistort T -o straight --json U.json"});
  add_take(*verb, options->undistort.take);
  add_out(*verb, options->undistort.out, "The new take's folder")->required();
  verb->add_option("--label", options->undistort.label, "The new take's label (default: as it was)");
  add_threads(*verb, options->undistort.threads);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_take_undistort(*options); }; });
}

}  // namespace floatstage::apps
