#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/verbs.h"
#include "pipeline/demo/demo.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct DemoArguments {
  pipeline::DemoOptions demo = pipeline::default_demo();
  std::filesystem::path json;
};

double mean_of(const std::vector<pipeline::Scores>& scores, double pipeline::Scores::*member) {
  double sum = 0;
  for (const pipeline::Scores& s : scores) sum += s.*member;
  return scores.empty() ? 0 : sum / static_cast<double>(scores.size());
}

nlohmann::json to_json(const pipeline::DemoOptions& options, const pipeline::DemoReport& report) {
  nlohmann::json json = {{"out", options.out.string()},
                         {"frames", options.studio.frames},
                         {"cameras", options.studio.rig.cameras},
                         {"seconds", report.seconds},
                         {"stage_seconds", report.stage_seconds}};
  for (const auto& [method, scores] : report.scores)
    json["scores"][method] = {{"views", scores.size()},
                              {"psnr_mask", mean_of(scores, &pipeline::Scores::psnr)},
                              {"ssim_mask", mean_of(scores, &pipeline::Scores::ssim)}};
  return json;
}

Result<void> run_demo(const DemoArguments& given) {
  pipeline::DemoOptions options = given.demo;
  ProgressBar bar;
  options.progress = &bar;
  Result<pipeline::DemoReport> report = pipeline::run_demo(options);
  if (!report) return forward(report);
  std::printf("%s: a take of %d frames from %d cameras became freeview.mp4 and compare.mp4 in %.1f s\n",
              options.out.c_str(), options.studio.frames, options.studio.rig.cameras, report->seconds);
  for (const auto& [stage, seconds] : report->stage_seconds)
    std::printf("  %-10s %6.1f s\n", stage.c_str(), seconds);
  std::printf("against what the studio really looks like from there, mean of %zu views:\n",
              report->scores.begin()->second.size());
  for (const auto& [method, scores] : report->scores)
    std::printf("  %-10s PSNR %.2f dB   SSIM %.4f\n", method.c_str(),
                mean_of(scores, &pipeline::Scores::psnr), mean_of(scores, &pipeline::Scores::ssim));
  return given.json.empty() ? Result<void>() : pipeline::save_json(to_json(options, *report), given.json);
}

}  // namespace

void add_demo(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<DemoArguments>();
  pipeline::DemoOptions& demo = options->demo;
  CLI::App* verb =
      add_verb(app, chosen, "demo", "The embedded synthetic studio through the whole main job",
               {"floatstage demo", "floatstage demo -o demo --camera-count 12 --frame-count 48 --blend 4"});
  add_out(*verb, demo.out, "Folder of the demo")->capture_default_str();
  add_frame_count(*verb, demo.studio.frames, "Instants of the take");
  add_camera_count(*verb, demo.studio.rig.cameras, 3);
  verb->add_option("--seed", demo.studio.studio.seed, "Same seed, same performance")->capture_default_str();
  add_blend(*verb, demo.blend);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_demo(*options); }; });
}

}  // namespace floatstage::apps
