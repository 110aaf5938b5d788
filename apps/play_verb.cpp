#include <algorithm>

#include "apps/interrupt.h"
#include "apps/renderer_options.h"
#include "apps/text_options.h"
#include "apps/verbs.h"
#include "apps/viewer/play/play.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::apps {
namespace {

struct Options {
  PlayOptions play;
  std::string size = "1280x800", view = "checker";
  bool by_hand = false;
  RendererFlags renderer;
};

Result<void> run(const Options& given) {
  PlayOptions options = given.play;
  Result<std::pair<int, int>> size = parse_size(given.size);
  if (!size) return forward(size);
  std::tie(options.width, options.height) = *size;
  Result<render::RendererOptions> renderer = renderer_options(given.renderer);
  if (!renderer) return forward(renderer);
  options.renderer = *renderer;
  const std::vector<std::string>& views = matte_view_names();
  options.view = static_cast<MatteView>(std::find(views.begin(), views.end(), given.view) - views.begin());
  options.automatic = !given.by_hand;
  options.stop = interrupted;
  return play_take(options);
}

}  // namespace

void add_play(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  options->renderer.background = "292b30";
  CLI::App* verb = app.add_subcommand(
      "play",
      "The interactive player: time line, orbit camera, comparison, camera path; and the matte editor");
  verb->add_option("take", options->play.take, "The take's folder")->required();
  verb->add_option("--method", options->play.method, method_help())->capture_default_str();
  verb->add_option("--compare", options->play.compare, "Split the screen: this method at the right");
  verb->add_option("--frame", options->play.frame, "Frame to begin with")->capture_default_str();
  verb->add_flag("--playing", options->play.playing, "Begin to play at once");
  verb->add_flag("--show-cameras", options->play.show_cameras, "Draw the cameras with thumbnails");
  verb->add_option("--path", options->play.path_file, "Begin with this camera path and follow it");
  verb->add_option("--size", options->size, "Size of the window")->capture_default_str();
  verb->add_option("--screenshot", options->play.screenshot,
                   "Write the window to this PNG once the picture stands, then end");
  add_renderer_flags(*verb, options->renderer);
  std::vector<std::string> methods;
  for (const pipeline::MatteMethod& m : pipeline::matte_methods()) methods.push_back(m.name);
  verb->add_flag("--mattes", options->play.mattes,
                 "Begin in the matte editor (M goes there and back); needs no meshes");
  verb->add_option("--camera", options->play.camera,
                   "Edit this camera's mattes: its serial; the first when left out");
  verb->add_option("--view", options->view, "Look at mattes as")
      ->capture_default_str()
      ->check(CLI::IsMember(matte_view_names()));
  verb->add_option("--matte-method", options->play.matte_method,
                   "Make mattes by this method of `matte`; as they were made when left out")
      ->check(CLI::IsMember(methods));
  verb->add_option("--guide", options->play.guide, "Others' mattes to start from, as in `matte`");
  verb->add_flag("--redo", options->play.redo, "Let the editor replace mattes that `matte` did not make");
  verb->add_flag("--by-hand", options->by_hand, "Make mattes when Enter is pressed, not after every edit");
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage::apps
