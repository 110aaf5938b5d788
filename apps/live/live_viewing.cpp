#include "apps/live/live_viewing.h"

#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/terminal/interrupt.h"
#include "apps/terminal/orbit_flags.h"
#include "apps/terminal/renderer_options.h"
#include "apps/viewer/live/live_window.h"
#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/camera_path.h"
#include "pipeline/film.h"
#include "pipeline/json_report.h"
#include "render/back_end.h"
#include "studio/live/live_chain.h"
#include "studio/live/live_remote.h"
#include "studio/messages/clock.h"

namespace floatstage::apps {
namespace {

nlohmann::ordered_json to_json(const studio::Series& s) {
  return {{"mean", s.mean()}, {"p50", s.percentile(0.5)}, {"p99", s.percentile(0.99)}, {"max", s.largest()}};
}

nlohmann::ordered_json to_report(const studio::LiveReport& r, const std::string& source,
                                 const std::string& renderer) {
  nlohmann::ordered_json json;
  json["source"] = source;
  json["renderer"] = renderer;
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
  json["silhouettes"] = nlohmann::ordered_json::array();
  for (const studio::SilhouetteChange& s : r.silhouettes)
    json["silhouettes"].push_back(
        {{"seconds", s.seconds}, {"doubts", s.news->doubts}, {"cameras", s.news->cameras}});
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
  for (const studio::SilhouetteChange& s : r.silhouettes)
    std::printf("  after %.0f s: %s\n", s.seconds,
                s.news->doubts.empty() ? "silhouettes fit again" : s.news->remark().c_str());
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

// What the silhouettes' doubts look like, named by their time.
Result<void> save_doubts(const studio::LiveReport& report, const std::filesystem::path& folder) {
  for (const studio::SilhouetteChange& s : report.silhouettes) {
    if (folder.empty() || s.news->picture.empty()) continue;
    char name[64];
    std::snprintf(name, sizeof name, "%06.2fs-doubt.png", s.seconds);
    if (Result<void> ok = save_png(s.news->picture, folder / name); !ok) return ok;
  }
  return {};
}

Result<void> view_headless(studio::SceneFeed& feed, const studio::RemoteScenes* network,
                           const LiveViewing& o) {
  Result<pipeline::CameraPath> path = o.path_file.empty()
                                          ? pipeline::orbit_around(feed.rig(), {}, o.orbit).path
                                          : pipeline::load_path_without_take(o.path_file);
  if (!path) return forward(path);
  const double duration = path->duration();
  const studio::ViewAt view_at = [&](double time) {
    return pipeline::view_of(pipeline::sample(*path, duration > 0 ? std::fmod(time, duration) : 0),
                             o.run.width, o.run.height, {});
  };
  if (!o.snapshots.empty())
    if (Result<void> ok = make_folder(o.snapshots); !ok) return ok;
  const Result<render::OpenBackEnd> drawing = render::open_back_end(o.run.renderer.back_end);
  if (!drawing) return forward(drawing);
  studio::LiveRunOptions options = o.run;
  options.renderer.back_end = drawing->back_end;
  Snapshots snapshots(o.snapshots, o.run.renderer.background);
  const Result<std::unique_ptr<capture::StreamOutput>> stream = open_stream(o.stream);
  if (!stream) return forward(stream);
  const auto visit = [&](const studio::LivePicture& p) {
    if (*stream)
      (*stream)->offer(pipeline::over(p.picture, o.run.renderer.background),
                       p.again ? std::nullopt : std::optional(p.scene->scene.produced));
    return snapshots.take(p);
  };
  const Timestamp begun = studio::now();
  const Result<studio::LiveReport> report = studio::run_live(feed, options, view_at, interrupted, visit);
  if (!report) return forward(report);
  print(*report);
  if (Result<void> ok = save_doubts(*report, o.snapshots); !ok) return ok;
  if (*stream) print_stream(**stream);
  if (o.json.empty()) return {};
  nlohmann::ordered_json json = to_report(*report, feed.description(), drawing->description);
  if (*stream) json["stream"] = to_json(**stream, o.stream);
  if (network != nullptr) json["network"] = to_json(network->network(), seconds(studio::now() - begun));
  return pipeline::save_json(json, o.json);
}

Result<void> view_in_window(studio::SceneFeed& feed, std::vector<studio::StudioControl*> nodes,
                            const LiveViewing& o) {
  if (studio::StudioControl* control = feed.control()) nodes.push_back(control);
  ControlModel model(std::move(nodes));
  const Result<std::unique_ptr<capture::StreamOutput>> stream = open_stream(o.stream);
  if (!stream) return forward(stream);
  const Result<void> shown = run_live_window(feed, model,
                                             {.run = o.run,
                                              .show_cameras = o.show_cameras,
                                              .stop = interrupted,
                                              .path_file = o.path_file,
                                              .screenshot = o.screenshot,
                                              .stream = stream->get()});
  if (shown && *stream) print_stream(**stream);
  return shown;
}

}  // namespace

void add_viewing_flags(CLI::App& verb, LiveViewing& o) {
  verb.add_flag("--headless", o.headless, "Without a window: the view walks around the stage");
  add_seconds(
      verb, o.run.seconds,
      "How long, a take beginning anew when it is over (default: once through; in a window until it is "
      "closed)");
  add_size(verb, o.size, "Size of the view (default: 640x480), or of the window (default: 1280x800)");
  add_json(verb, o.json);
  add_blend(verb, o.blend);
  add_background(verb, o.background);
  add_back_end_flag(verb, o.back_end);
  verb.add_option("--orbit", o.orbit.seconds, "Headless: seconds of a walk around the stage")
      ->capture_default_str()
      ->check(CLI::PositiveNumber)
      ->group(kGroupPicture);
  add_orbit_flags(verb, o.orbit, nullptr);
  verb.add_option("--path", o.path_file, "Follow this camera path instead, again and again")
      ->group(kGroupPicture);
  verb.add_option("--snapshots", o.snapshots,
                  "Headless: write a picture a second into this folder, and what is wrong with silhouettes")
      ->group(kGroupPicture);
  add_stream_flags(verb, o.stream);
  verb.add_flag("--show-cameras", o.show_cameras, "Draw the cameras")->group(kGroupWindow);
  verb.add_option("--screenshot", o.screenshot,
                  "Write the window to this PNG once a few scenes were shown, then end")
      ->group(kGroupWindow);
  add_alignment(verb, o.alignment);
  std::string levels = "Quality to begin with:";
  for (std::size_t i = 0; i < studio::live_qualities().size(); ++i)
    levels += text("\n  ", i, " ", describe(studio::live_qualities()[i]));
  verb.add_option("--quality", o.run.quality, levels)->capture_default_str()->group(kGroupTuning);
  verb.add_option("--target-fps", o.run.target_fps,
                  "Change the quality to show so many instants a second; 0: never")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber)
      ->group(kGroupTuning);
}

Result<void> settle(LiveViewing& o) {
  if (!o.headless && !(o.json.empty() && o.snapshots.empty()))
    return fail(ErrorCode::InvalidArgument,
                "--json and --snapshots are of a run without a window; add --headless");
  if (o.headless && !o.screenshot.empty())
    return fail(ErrorCode::InvalidArgument,
                "--screenshot is of the window; without one there is --snapshots");
  if (o.size.width == 0) o.size = o.headless ? Size{640, 480} : Size{1280, 800};
  if (Result<void> ok = settle(o.stream, o.headless ? o.size : Size{1280, 720}); !ok) return ok;
  o.run.width = o.size.width;
  o.run.height = o.size.height;
  RendererFlags flags;
  flags.background = o.background;
  flags.back_end = o.back_end;
  flags.alignment = o.alignment;
  flags.options.cameras = o.blend;
  const Result<render::RendererOptions> renderer = renderer_options(flags);
  if (!renderer) return forward(renderer);
  o.run.renderer = *renderer;
  return {};
}

Result<void> view_scenes(studio::SceneFeed& feed, const studio::RemoteScenes* network,
                         std::vector<studio::StudioControl*> nodes, const LiveViewing& viewing) {
  return viewing.headless ? view_headless(feed, network, viewing)
                          : view_in_window(feed, std::move(nodes), viewing);
}

}  // namespace floatstage::apps
