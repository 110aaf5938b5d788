#include "apps/play/player.h"
#include "apps/renderer_options.h"
#include "apps/text_options.h"
#include "apps/verbs.h"

namespace floatstage {
namespace {

struct Options {
  PlayOptions play;
  std::string size = "1280x800";
  RendererFlags renderer;
};

Result<void> run(const Options& given) {
  PlayOptions options = given.play;
  Result<std::pair<int, int>> size = parse_size(given.size);
  if (!size) return forward(size);
  std::tie(options.width, options.height) = *size;
  Result<RendererOptions> renderer = renderer_options(given.renderer);
  if (!renderer) return forward(renderer);
  options.renderer = *renderer;
  return play_take(options);
}

}  // namespace

void add_play(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  options->renderer.background = "292b30";
  CLI::App* verb = app.add_subcommand("play", "The interactive player: time line, orbit camera, comparison, camera path");
  verb->add_option("take", options->play.take, "The take's folder")->required();
  verb->add_option("--method", options->play.method, method_help())->capture_default_str();
  verb->add_option("--compare", options->play.compare, "Split the screen: this method at the right");
  verb->add_option("--frame", options->play.frame, "Frame to begin with")->capture_default_str();
  verb->add_flag("--playing", options->play.playing, "Begin to play at once");
  verb->add_flag("--show-cameras", options->play.show_cameras, "Draw the cameras with thumbnails");
  verb->add_option("--path", options->play.path_file, "Begin with this camera path and follow it");
  verb->add_option("--size", options->size, "Size of the window")->capture_default_str();
  verb->add_option("--screenshot", options->play.screenshot, "Write the window to this PNG once the picture stands, then end");
  add_renderer_flags(*verb, options->renderer);
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage
