#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/export/export_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/text_options.h"
#include "pipeline/export/export_web.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct WebArguments {
  pipeline::ExportWebOptions web;
  std::string frames, background = "000000";
  std::filesystem::path path, json;
  bool no_sound = false;
};

Result<void> run_web(const WebArguments& given) {
  pipeline::ExportWebOptions options = given.web;
  Result<std::vector<int>> frames = frames_of_take(options.take, given.frames);
  if (!frames) return forward(frames);
  options.frames = std::move(*frames);
  const Result<std::array<float, 3>> background = parse_color(given.background);
  if (!background) return forward(background);
  options.background = *background;
  options.sound = !given.no_sound;
  if (!given.path.empty()) {
    Result<pipeline::CameraPath> path = pipeline::load_path(given.path);
    if (!path) return forward(path);
    options.path = std::move(*path);
  }
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::ExportWebReport> report = pipeline::export_web(options);
  if (!report) return forward(report);
  std::printf("%s: %d frames, %.1f MB; open %s in a browser\n", options.out.c_str(), report->frames,
              static_cast<double>(report->bytes) / 1e6, (options.out / "index.html").c_str());
  if (report->sound > 0) std::printf("the take's sound is heard for %.1f s\n", report->sound);
  if (given.json.empty()) return {};
  return pipeline::save_json({{"out", options.out.string()},
                              {"frames", report->frames},
                              {"bytes", report->bytes},
                              {"sound_seconds", report->sound}},
                             given.json);
}

}  // namespace

void add_export_web(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<WebArguments>();
  CLI::App* verb =
      add_verb(parent, chosen, "web", "A page that plays the take in any browser, from a disk or any server",
               {"floatstage export web take -o page",
                "floatstage export web take --frames 0:100:2 --path path.json -o page"});
  add_take(*verb, options->web.take);
  add_label_choice(*verb, options->web.labels);
  add_out(*verb, options->web.out, "A new folder; open its index.html")->required();
  add_frames(*verb, options->frames, "all");
  verb->add_option("--path", options->path, "A camera path written by `floatstage play`, for a button")
      ->type_name("FILE");
  add_blend(*verb, options->web.blend);
  add_background(*verb, options->background);
  verb->add_option("--quality", options->web.quality, "Of the photographs, as JPEG has it: 1 to 100")
      ->capture_default_str()
      ->type_name("N");
  verb->add_flag("--no-sound", options->no_sound, "Leave out the take's sound");
  verb->add_option("--sound", options->web.sound_track,
                   "The sound track that is heard (default: the take's first)")
      ->type_name("NAME")
      ->excludes("--no-sound");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_web(*options); }; });
}

}  // namespace floatstage::apps
