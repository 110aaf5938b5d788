#include <cstdio>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "apps/export/export_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/progress_bar.h"
#include "pipeline/export/export_easyvolcap.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct EasyvolcapArguments {
  pipeline::ExportEasyVolcapOptions easyvolcap;
  std::string frames;
  std::filesystem::path json;
};

Result<void> run_easyvolcap(const EasyvolcapArguments& given) {
  pipeline::ExportEasyVolcapOptions options = given.easyvolcap;
  Result<std::vector<int>> frames = frames_of_take(options.take, given.frames);
  if (!frames) return forward(frames);
  options.frames = std::move(*frames);
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::ExportEasyVolcapReport> report = pipeline::export_easyvolcap(options);
  if (!report) return forward(report);
  if (!report->left_out.empty())
    spdlog::warn("{} of {} frames are left out, the first is {}: not every camera has a picture of them",
                 report->left_out.size(), options.frames.size(), report->left_out.front());
  std::printf("%s: %d pictures of %d instants\n", options.out.c_str(), report->pictures, report->frames);
  if (given.json.empty()) return {};
  return pipeline::save_json({{"out", options.out.string()},
                              {"frames", report->frames},
                              {"pictures", report->pictures},
                              {"masks", report->masks},
                              {"left_out", report->left_out}},
                             given.json);
}

}  // namespace

void add_export_easyvolcap(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<EasyvolcapArguments>();
  CLI::App* verb =
      add_verb(parent, chosen, "easyvolcap", "A sequence for EasyVolcap: pictures, masks, cameras, hulls",
               {"floatstage export easyvolcap take -o sequence",
                "floatstage export easyvolcap take --frames 0:50 --cameras cam01,cam04 -o sequence"});
  add_take(*verb, options->easyvolcap.take);
  add_label_choice(*verb, options->easyvolcap.labels);
  add_out(*verb, options->easyvolcap.out, "A new folder")->required();
  add_frames(*verb, options->frames, "all");
  add_cameras(*verb, options->easyvolcap.cameras);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_easyvolcap(*options); }; });
}

}  // namespace floatstage::apps
