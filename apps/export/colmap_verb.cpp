#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/export/export_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/progress_bar.h"
#include "pipeline/export/export_colmap.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct ColmapArguments {
  pipeline::ExportColmapOptions colmap;
  std::string frames;
  std::filesystem::path json;
};

Result<void> run_colmap(const ColmapArguments& given) {
  pipeline::ExportColmapOptions options = given.colmap;
  Result<std::vector<int>> frames = frames_of_take(options.take, given.frames.empty() ? "0" : given.frames);
  if (!frames) return forward(frames);
  options.frames = std::move(*frames);
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::ExportColmapReport> report = pipeline::export_colmap(options);
  if (!report) return forward(report);
  std::printf("%s: %d pictures of %d instants, %zu points\n", options.out.c_str(), report->pictures,
              report->frames, report->points);
  if (given.json.empty()) return {};
  return pipeline::save_json({{"out", options.out.string()},
                              {"frames", report->frames},
                              {"pictures", report->pictures},
                              {"masks", report->masks},
                              {"points", report->points}},
                             given.json);
}

}  // namespace

void add_export_colmap(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<ColmapArguments>();
  CLI::App* verb =
      add_verb(parent, chosen, "colmap",
               "Instants for COLMAP, Gaussian splats and NeRFs: pictures, masks, cameras, points",
               {"floatstage export colmap take -o project",
                "floatstage export colmap take --frames 0:50:10 -o projects"});
  add_take(*verb, options->colmap.take);
  add_label_choice(*verb, options->colmap.labels);
  add_out(*verb, options->colmap.out, "A new folder; of several frames it holds one for each")->required();
  add_frames(*verb, options->frames, "the first");
  add_cameras(*verb, options->colmap.cameras);
  verb->add_flag("--alpha", options->colmap.alpha,
                 "Pictures carry their mattes as alpha too, which some trainers read in the place of masks");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_colmap(*options); }; });
}

}  // namespace floatstage::apps
