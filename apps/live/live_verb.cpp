#include <algorithm>
#include <cmath>

#include "apps/live/live_verbs.h"
#include "apps/live/live_viewing.h"
#include "apps/terminal/interrupt.h"
#include "core/text.h"
#include "studio/live/camera_source.h"
#include "studio/live/live_chain.h"
#include "studio/live/take_player.h"

namespace floatstage::apps {
namespace {

struct LiveArguments {
  std::filesystem::path source, config, plates;
  double rate = 0;
  studio::TakePlayerOptions player;
  studio::LiveChainOptions chain;
  LiveViewing viewing;
};

// A take that plays, or the cameras of a studio's file.
Result<std::unique_ptr<studio::LiveSource>> open_live_source(const LiveArguments& o) {
  if (o.source.empty() == o.config.empty())
    return fail(ErrorCode::InvalidArgument,
                "say where pictures come from: --source TAKE or --config STUDIO.toml; for scenes of another "
                "machine there is `floatstage live view`");
  if (!o.config.empty()) {
    Result<studio::CaptureConfig> config = studio::load_capture_config(o.config);
    if (!config) return forward(config);
    // Who wants to see something for so long does not wait much longer for the first picture.
    const double wanted = o.viewing.run.seconds;
    const Nanoseconds patience{std::llround(1e9 * (wanted > 0 ? std::min(10.0, wanted + 2) : 10.0))};
    Result<std::unique_ptr<studio::CameraSource>> cameras =
        studio::CameraSource::open(std::move(*config), o.plates, interrupted, patience);
    if (!cameras) return forward(cameras);
    return std::unique_ptr<studio::LiveSource>(std::move(*cameras));
  }
  studio::TakePlayerOptions player = o.player;
  player.rate = o.rate;
  player.stop = interrupted;
  player.loop = o.viewing.run.seconds > 0 || !o.viewing.headless;
  Result<std::unique_ptr<studio::TakePlayer>> take = studio::TakePlayer::open(o.source, player);
  if (!take) return forward(take);
  return std::unique_ptr<studio::LiveSource>(std::move(*take));
}

Result<void> run_live(const LiveArguments& given) {
  LiveViewing viewing = given.viewing;
  if (Result<void> ok = settle(viewing); !ok) return ok;
  Result<std::unique_ptr<studio::LiveSource>> source = open_live_source(given);
  if (!source) return forward(source);
  Result<std::unique_ptr<studio::LiveChain>> chain = studio::LiveChain::make(**source, given.chain);
  if (!chain) return forward(chain);
  (*chain)->begin();
  return view_scenes(**chain, nullptr, {}, viewing);
}

}  // namespace

void add_live(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<LiveArguments>();
  CLI::App* verb =
      add_verb(app, chosen, "live", "Cameras, or a take in their place, as a scene that one walks around now",
               {"floatstage live --source take", "floatstage live --config studio.toml --size 1920x1080"});
  verb->add_option("--source", options->source, "A take, played as if its cameras delivered it now")
      ->type_name("TAKE");
  verb->add_option("--config", options->config, "The studio's cameras (TOML, as for `capture`)")
      ->type_name("FILE");
  verb->add_option("--plates", options->plates,
                   "With --config: a folder of clean plates, <serial>.png, for keyers that need one")
      ->type_name("FOLDER");
  verb->add_option("--rate", options->rate, "With --source: instants a second (default: as recorded)")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  add_matte_keyer(*verb, options->chain.key);
  add_threads(*verb, options->chain.threads);
  add_viewing_flags(*verb, options->viewing);
  add_live_recon(*verb, chosen);
  add_live_view(*verb, chosen);
  verb->require_subcommand(0, 1);
  verb->callback([options, verb, &chosen] {
    if (verb->get_subcommands().empty()) chosen.run = [options] { return run_live(*options); };
  });
}

}  // namespace floatstage::apps
