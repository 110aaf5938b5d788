#include <algorithm>

#include <nlohmann/json.hpp>

#include "apps/terminal/flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/renderer_options.h"
#include "apps/verbs.h"
#include "apps/viewer/play/play.h"
#include "capture/sound/sound_output.h"
#include "core/text.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct PlayArguments {
  PlayOptions play;
  std::string view = "checker";
  Size size{1280, 800};
  bool by_hand = false;
  RendererFlags renderer;
  std::filesystem::path json_file;
};

nlohmann::json to_json(const PictureTimes& times) {
  return {{"pictures", times.count()},
          {"median_ms", times.percentile(0.5)},
          {"p95_ms", times.percentile(0.95)},
          {"worst_ms", times.worst()}};
}

nlohmann::json to_json(const PlayReport& report) {
  const CanvasTimes& times = report.pictures;
  nlohmann::json moving = to_json(times.moving);
  moving["per_second"] = times.moving_seconds > 0 ? times.moving_steps / times.moving_seconds : 0;
  moving["coarsest"] = times.coarsest;
  moving["without_flow"] = times.without_flow;
  nlohmann::json at_rest = to_json(times.at_rest);
  at_rest["given_up"] = times.given_up;
  nlohmann::json heard = nlohmann::json::array();
  for (const ShownWhileHeard& shown : report.heard) heard.push_back({shown.frame, shown.output, shown.heard});
  return {{"at_rest", std::move(at_rest)},
          {"moving", std::move(moving)},
          {"after_input", to_json(report.after_input)},
          {"frame", report.frame},
          {"events", report.events},
          {"keys", report.keys},
          {"presses", report.presses},
          {"renderer", report.renderer},
          {"heard", std::move(heard)}};
}

Result<void> run_play(const PlayArguments& given) {
  PlayOptions options = given.play;
  options.width = given.size.width;
  options.height = given.size.height;
  Result<render::RendererOptions> renderer = renderer_options(given.renderer);
  if (!renderer) return forward(renderer);
  options.renderer = *renderer;
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options.take);
  if (!take) return forward(take);
  if (Result<void> ok = suit_cameras(given.renderer, (*take)->rig(), options.renderer); !ok)
    return forward(ok);
  options.balance = given.renderer.balance;
  options.view = static_cast<MatteView>(place_of(matte_view_names(), given.view));
  options.automatic = !given.by_hand;
  options.stop = interrupted;
  const Result<PlayReport> report = play_take(options);
  if (!report) return forward(report);
  if (given.json_file.empty()) return {};
  return pipeline::save_json(to_json(*report), given.json_file);
}

}  // namespace

void add_play(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<PlayArguments>();
  PlayOptions& play = options->play;
  options->renderer.background = "292b30";
  CLI::App* verb = add_verb(
      app, chosen, "play",
      "The interactive player: time line, orbit camera, comparison, camera path; and the matte editor",
      {"floatstage play take --compare linear", "floatstage play take --mattes --camera cam02 --frame 40"});
  add_take(*verb, play.take);
  add_label_choice(*verb, play.labels);
  verb->add_option("--method", play.method, method_help())
      ->capture_default_str()
      ->check(one_of(renderer_names()));
  verb->add_option("--compare", play.compare, "Split the screen: this method at the right")
      ->check(one_of(renderer_names()));
  verb->add_option("--frame", play.frame, "Frame to begin with")->capture_default_str()->type_name("N");
  verb->add_flag("--playing", play.playing, "Begin to play at once");
  verb->add_option("--path", play.path_file, "Begin with this camera path and follow it")->type_name("FILE");
  CLI::Option* track =
      verb->add_option("--sound", play.track, "The sound track that is heard first (default: the first)")
          ->type_name("NAME");
  CLI::Option* output = verb->add_option("--sound-output", play.sound_output,
                                         text("Where it is heard: ", capture::kSoundOutputUsage))
                            ->capture_default_str()
                            ->type_name("OUTPUT")
                            ->group(kGroupWindow);
  verb->add_flag("!--no-sound", play.sound, "Stay silent")->excludes(track)->excludes(output);
  add_size(*verb, options->size, "Size of the window");
  add_renderer_flags(*verb, options->renderer);
  verb->add_flag("--show-cameras", play.show_cameras, "Draw the cameras with thumbnails")
      ->group(kGroupWindow);
  verb->add_option("--screenshot", play.screenshot,
                   "Write the window to this PNG once the picture stands, then end")
      ->type_name("FILE")
      ->group(kGroupWindow);
  add_json(*verb, options->json_file);
  const std::vector<CLI::Option*> mattes = {
      verb->add_flag("--mattes", play.mattes,
                     "Begin in the matte editor (M goes there and back); needs no meshes"),
      verb->add_option("--camera", play.camera, "Edit this camera's mattes: its serial (default: the first)"),
      verb->add_option("--view", options->view, "Look at mattes as")
          ->capture_default_str()
          ->check(one_of(matte_view_names())),
      add_matte_how(*verb, play.matte, kUsualMattes),
      add_guide(*verb, play.guide),
      verb->add_flag("--by-hand", options->by_hand,
                     "Make mattes when Enter is pressed, not after every edit")};
  for (CLI::Option* option : mattes) option->group(kGroupMattes);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_play(*options); }; });
}

}  // namespace floatstage::apps
