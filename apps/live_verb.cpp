#include <chrono>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/interrupt.h"
#include "apps/renderer_options.h"
#include "apps/text_options.h"
#include "apps/verbs.h"
#include "apps/viewer/live/live_window.h"
#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/camera_path.h"
#include "pipeline/film.h"
#include "pipeline/json_report.h"
#include "render/gl_context.h"
#include "studio/live/camera_source.h"
#include "studio/live/live_chain.h"
#include "studio/live/live_recon.h"
#include "studio/live/live_remote.h"
#include "studio/live/live_run.h"
#include "studio/live/take_player.h"
#include "studio/messages/clock.h"

namespace floatstage::apps {
namespace {

struct Options {
  studio::LiveReconOptions recon;
  studio::LiveRemoteOptions remote;
  std::filesystem::path source, config, plates, json, snapshots, path_file, screenshot;
  std::string size, background = "000000";
  bool headless = false, show_cameras = false;
  double rate = 0, orbit = 20;
  int cameras = 3;
  studio::TakePlayerOptions player;
  studio::LiveChainOptions chain;
  studio::LiveRunOptions run;
};

nlohmann::ordered_json to_json(const studio::Series& s) {
  return {{"mean", s.mean()}, {"p50", s.percentile(0.5)}, {"p99", s.percentile(0.99)}, {"max", s.largest()}};
}

nlohmann::ordered_json to_report(const studio::LiveReport& r, const std::string& source,
                                 const std::string& gl) {
  nlohmann::ordered_json json;
  json["source"] = source;
  json["gl"] = gl;
  json["seconds"] = r.seconds;
  json["fps"] = r.shown.mean(r.seconds);
  json["fps_slowest_second"] = r.shown.slowest(r.seconds, 1);
  json["fps_slowest_5_seconds"] = r.shown.slowest(r.seconds, 5);
  json["view_fps"] = r.pictures.mean(r.seconds);
  json["latency_ms"] = to_json(r.latency);
  for (const auto& [name, series] : r.stages) json["stages_ms"][name] = to_json(series);
  const studio::LiveChain::Counters& c = r.counters;
  std::uint64_t late = 0, missing = 0;
  for (const capture::CameraSync& camera : c.sets.sync.cameras)
    late += camera.late, missing += camera.missing;
  json["sets"] = {
      {"ready", c.sets.sets}, {"complete", c.sets.sync.complete}, {"incomplete", c.sets.sync.incomplete}};
  json["scenes"] = c.scenes;
  json["dropped"] = {
      {"sets_overtaken", c.sets.overtaken}, {"scenes_unseen", c.unseen}, {"sets_failed", c.failed},
      {"sets_troubled", c.troubled},        {"frames_late", late},       {"frames_missing", missing}};
  for (const studio::QualityChange& q : r.qualities)
    json["qualities"].push_back({{"seconds", q.seconds}, {"quality", q.quality}, {"fps", q.fps}});
  return json;
}

void print(const studio::LiveReport& r) {
  std::printf("%.1f scenes a second over %.0f s (slowest second %.0f), latency p50 %.0f ms, p99 %.0f ms\n",
              r.shown.mean(r.seconds), r.seconds, r.shown.slowest(r.seconds, 1), r.latency.percentile(0.5),
              r.latency.percentile(0.99));
  for (const auto& [name, series] : r.stages)
    std::printf("  %-12s mean %6.1f ms, p99 %6.1f ms\n", name.c_str(), series.mean(),
                series.percentile(0.99));
  std::printf("  %llu instants came, %llu were shown, %llu overtaken by newer ones\n",
              static_cast<unsigned long long>(r.counters.sets.sets),
              static_cast<unsigned long long>(r.counters.scenes),
              static_cast<unsigned long long>(r.counters.sets.overtaken));
}

// A picture a second, named by its time and instant.
class Snapshots {
 public:
  Snapshots(std::filesystem::path folder, const std::array<float, 3>& background)
      : folder_(std::move(folder)), background_(background) {}
  Result<void> take(const studio::LivePicture& p) {
    if (folder_.empty() || p.seconds < next_) return {};
    next_ = p.seconds + 1;
    char name[64];
    std::snprintf(name, sizeof name, "%06.2fs-instant%06llu.png", p.seconds,
                  static_cast<unsigned long long>(p.scene->scene.epoch));
    return save_png(pipeline::over(p.picture, background_), folder_ / name);
  }

 private:
  const std::filesystem::path folder_;
  const std::array<float, 3> background_;
  double next_ = 0;
};

// A take that plays, or the cameras of a studio's file.
Result<std::unique_ptr<studio::LiveSource>> open_live_source(const Options& o) {
  if (o.source.empty() == o.config.empty())
    return fail(ErrorCode::InvalidArgument,
                "say where pictures come from: --source TAKE, --config STUDIO.toml, or --view ADDRESS of "
                "other machines");
  if (!o.config.empty()) {
    Result<studio::CaptureConfig> config = studio::load_capture_config(o.config);
    if (!config) return forward(config);
    Result<std::unique_ptr<studio::CameraSource>> cameras =
        studio::CameraSource::open(std::move(*config), o.plates);
    if (!cameras) return forward(cameras);
    return std::unique_ptr<studio::LiveSource>(std::move(*cameras));
  }
  studio::TakePlayerOptions player = o.player;
  player.rate = o.rate;
  player.loop = o.run.seconds > 0 || !o.headless;
  Result<std::unique_ptr<studio::TakePlayer>> take = studio::TakePlayer::open(o.source, player);
  if (!take) return forward(take);
  return std::unique_ptr<studio::LiveSource>(std::move(*take));
}

// `network` is null for scenes of this process.
Result<void> view_headless(studio::SceneFeed& feed, const studio::RemoteScenes* network, const Options& o) {
  Result<pipeline::CameraPath> path =
      o.path_file.empty() ? pipeline::orbit_path(feed.rig(), {}, o.orbit) : pipeline::load_path(o.path_file);
  if (!path) return forward(path);
  const double duration = path->duration();
  const studio::ViewAt view_at = [&](double time) {
    return pipeline::view_of(pipeline::sample(*path, duration > 0 ? std::fmod(time, duration) : 0),
                             o.run.width, o.run.height, {});
  };
  if (!o.snapshots.empty())
    if (Result<void> ok = make_folder(o.snapshots); !ok) return ok;
  Result<std::unique_ptr<render::GlContext>> gl = render::GlContext::headless();
  if (!gl) return forward(gl);
  Snapshots snapshots(o.snapshots, o.run.renderer.background);
  const Timestamp begun = studio::now();
  const Result<studio::LiveReport> report = studio::run_live(
      feed, o.run, view_at, interrupted, [&](const studio::LivePicture& p) { return snapshots.take(p); });
  if (!report) return forward(report);
  print(*report);
  if (o.json.empty()) return {};
  nlohmann::ordered_json json = to_report(*report, feed.description(), (*gl)->description());
  if (network != nullptr) json["network"] = to_json(network->network(), seconds(studio::now() - begun));
  return pipeline::save_json(json, o.json);
}

Result<void> view_in_window(studio::SceneFeed& feed, std::vector<studio::StudioControl*> nodes,
                            const Options& o) {
  if (studio::StudioControl* control = feed.control()) nodes.push_back(control);
  ControlModel control_model(std::move(nodes));
  return run_live_window(feed, control_model,
                         {.run = o.run,
                          .show_cameras = o.show_cameras,
                          .stop = interrupted,
                          .path_file = o.path_file,
                          .screenshot = o.screenshot});
}

Result<void> view_remote(const Options& o) {
  const Result<studio::LiveRemote> remote = studio::open_live_remote(o.remote);
  if (!remote) return forward(remote);
  if (o.headless) return view_headless(*remote->scenes, remote->scenes.get(), o);
  std::vector<studio::StudioControl*> nodes;
  for (const auto& node : remote->control) nodes.push_back(node.get());
  return view_in_window(*remote->scenes, std::move(nodes), o);
}

Result<void> reconstruct(const Options& o) {
  studio::LiveReconOptions recon = o.recon;
  recon.nodes = o.remote.nodes;
  recon.rig = o.remote.rig;
  recon.keys = o.remote.keys;
  recon.seconds = o.run.seconds;
  const Result<studio::LiveReconReport> report = studio::run_live_recon(recon, interrupted);
  if (!report) return forward(report);
  const studio::ReconCounters& counters = report->counters;
  std::printf("%.1f scenes a second over %.0f s, hull p50 %.0f ms; %.1f kB a second came, %.1f kB went\n",
              static_cast<double>(counters.scenes) / report->seconds, report->seconds,
              counters.hull_ms.percentile(0.5),
              1e-3 * static_cast<double>(counters.from_nodes.bytes) / report->seconds,
              1e-3 * static_cast<double>(counters.to_viewers.scene_bytes) / report->seconds);
  if (o.json.empty()) return {};
  return pipeline::save_json(to_json(*report), o.json);
}

Result<void> run(const Options& given) {
  if (!given.recon.address.empty()) return reconstruct(given);
  Options o = given;
  if (!o.headless && !(o.json.empty() && o.snapshots.empty()))
    return fail(ErrorCode::InvalidArgument,
                "--json and --snapshots are of a run without a window; add --headless");
  if (o.headless && !o.screenshot.empty())
    return fail(ErrorCode::InvalidArgument,
                "--screenshot is of the window; without one there is --snapshots");
  Result<std::pair<int, int>> size = parse_size(!o.size.empty() ? o.size
                                                : o.headless    ? "640x480"
                                                                : "1280x800");
  if (!size) return forward(size);
  std::tie(o.run.width, o.run.height) = *size;
  RendererFlags flags;
  flags.background = o.background;
  flags.options.cameras = o.cameras;
  Result<render::RendererOptions> renderer = renderer_options(flags);
  if (!renderer) return forward(renderer);
  o.run.renderer = *renderer;
  if (!o.remote.recon.empty()) return view_remote(o);
  Result<std::unique_ptr<studio::LiveSource>> source = open_live_source(o);
  if (!source) return forward(source);
  Result<std::unique_ptr<studio::LiveChain>> chain = studio::LiveChain::make(**source, o.chain);
  if (!chain) return forward(chain);
  (*chain)->begin();
  return o.headless ? view_headless(**chain, nullptr, o) : view_in_window(**chain, {}, o);
}

}  // namespace

void add_live(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  Options& o = *options;
  CLI::App* verb =
      app.add_subcommand("live", "Cameras, or a take in their place, as a scene that one walks around now");
  CLI::Option* source =
      verb->add_option("--source", o.source, "A take, played as if its cameras delivered it now");
  CLI::Option* config =
      verb->add_option("--config", o.config, "The studio's cameras (TOML, as for `capture`)");
  CLI::Option* recon = verb->add_option(
      "--recon", o.recon.address, "Reconstruct what --nodes see, and tell scenes at this address; no view");
  CLI::Option* view = verb->add_option("--view", o.remote.recon,
                                       "View the scenes of the machine with --recon at this address");
  CLI::Option* nodes =
      verb->add_option("--nodes", o.remote.nodes, "With --recon, --view: addresses of the capture nodes");
  verb->add_option("--control", o.remote.control,
                   "With --view: where the nodes answer requests, for health, record and stop");
  CLI::Option* rig = verb->add_option("--rig", o.remote.rig, "With --recon, --view: the studio's rig.json");
  verb->add_option("--keys", o.remote.keys, "With --recon, --view: the studio's keys, see `floatstage keys`");
  verb->add_option("--longest-wait", o.recon.longest_wait_ms,
                   "With --recon: ms that an instant waits for late cameras")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  recon->excludes(source)->excludes(config)->excludes(view)->needs(nodes)->needs(rig);
  view->excludes(source)->excludes(config)->needs(nodes)->needs(rig);
  verb->add_option("--plates", o.plates,
                   "With --config: a folder of clean plates, <serial>.png, for keyers that need one");
  verb->add_flag("--headless", o.headless, "Without a window: the view walks around the stage");
  verb->add_option("--seconds", o.run.seconds,
                   "How long, the take beginning anew when it is over; default: once through, in a window "
                   "until it is closed")
      ->check(CLI::PositiveNumber);
  verb->add_option("--rate", o.rate, "Instants a second; default: as recorded")->check(CLI::PositiveNumber);
  verb->add_option("--out-size", o.size,
                   "Size of the view (default: 640x480), or of the window (default: 1280x800)");
  verb->add_option("--key", o.chain.key, "How the subject is keyed, see `floatstage process --help`")
      ->capture_default_str();
  verb->add_option("--cameras", o.cameras, "Photographs blended per view")->capture_default_str();
  std::string levels = "Quality to begin with:";
  for (std::size_t i = 0; i < studio::live_qualities().size(); ++i)
    levels += text("\n  ", i, " ", studio::describe(studio::live_qualities()[i]));
  verb->add_option("--quality", o.run.quality, levels)->capture_default_str();
  verb->add_option("--target-fps", o.run.target_fps,
                   "Change the quality to show so many instants a second; 0: never")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  verb->add_option("--orbit", o.orbit, "Headless: seconds of a walk around the stage")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  verb->add_option("--path", o.path_file, "Follow this camera path instead, again and again");
  verb->add_option("--background", o.background, "Colour behind the performer, rrggbb")
      ->capture_default_str();
  verb->add_option("--snapshots", o.snapshots, "Headless: write a picture a second into this folder");
  verb->add_flag("--show-cameras", o.show_cameras, "Window: draw the cameras");
  verb->add_option("--screenshot", o.screenshot,
                   "Window: write it to this PNG once a few scenes were shown, then end");
  verb->add_option("--json", o.json, "Headless, --recon: write a report for machines");
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage::apps
