#include <cstdio>

#include "apps/progress_bar.h"
#include "apps/verbs.h"
#include "pipeline/demo/demo.h"

namespace floatstage::apps {
namespace {

double mean_of(const std::vector<pipeline::Scores>& scores, double pipeline::Scores::*member) {
  double sum = 0;
  for (const pipeline::Scores& s : scores) sum += s.*member;
  return scores.empty() ? 0 : sum / static_cast<double>(scores.size());
}

Result<void> run(pipeline::DemoOptions options) {
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
  return {};
}

}  // namespace

void add_demo(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<pipeline::DemoOptions>(pipeline::default_demo());
  CLI::App* verb = app.add_subcommand("demo", "The embedded synthetic studio through the whole main job");
  verb->add_option("--out", options->out, "Folder of the demo")->capture_default_str();
  verb->add_option("--frames", options->studio.frames, "Instants of the take")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  verb->add_option("--cameras", options->studio.rig.cameras, "Cameras around the stage")
      ->capture_default_str()
      ->check(CLI::Range(3, 1000));
  verb->add_option("--seed", options->studio.studio.seed, "Same seed, same performance")
      ->capture_default_str();
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage::apps
