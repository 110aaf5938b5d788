#include "studio/live/live_run.h"

#include <algorithm>
#include <cmath>

#include "core/log.h"
#include "core/text.h"
#include "studio/live/live_pace.h"
#include "studio/messages/clock.h"

namespace floatstage::studio {
namespace {

constexpr double kWarmUp = 2;  // seconds: shaders are compiled, storage grows

enum Stage { Wait, Nodes, Hull, Handover, Upload, Render, Download, Key, Outline, Tile, kStages };
constexpr const char* kNames[kStages] = {"wait",   "nodes",    "hull",    "handover",    "upload",
                                         "render", "download", "key_sum", "outline_sum", "tile_sum"};

class Run {
 public:
  Run(SceneFeed& chain, const LiveRunOptions& options)
      : chain_(chain), options_(options), view_(chain.rig()), pace_(options.target_fps, options.quality) {
    for (const char* name : kNames) report_.stages.emplace_back(name, Series());
  }

  Result<LiveReport> draw(const ViewAt& view_at, const std::function<bool()>& stop,
                          const std::function<Result<void>(const LivePicture&)>& visit);

 private:
  const LiveQuality& quality() const { return live_qualities()[pace_.quality()]; }
  void use_quality(double fps);
  Result<void> warm_up(const View& view);
  Result<void> picture(const std::shared_ptr<const LiveScene>& fresh, const ViewAt& view_at,
                       const std::function<Result<void>(const LivePicture&)>& visit);
  void measure(const LiveScene& scene, const double (&ms)[kStages], Timestamp done);
  void judge(Timestamp time);
  void listen(Timestamp time);
  double at(Timestamp time) const { return begun_ ? seconds(time - *begun_) : 0; }
  bool warm(Timestamp time) const { return begun_ && at(time) >= kWarmUp; }

  SceneFeed& chain_;
  const LiveRunOptions& options_;
  LiveView view_;
  LivePace pace_;
  LiveReport report_;
  std::optional<Timestamp> begun_;
  SceneFeed::Counters at_warm_;
  bool was_warm_ = false;
};

void Run::use_quality(double fps) {
  chain_.set_quality(quality().node);
  const double time = at(now());
  report_.qualities.push_back({time, describe(quality()), fps});
  log::info(text("live quality after ", std::lround(time), " s at ", std::round(10 * fps) / 10,
                 " scenes a second: ", describe(quality())));
}

// The shaders of the methods that other qualities have: a change of quality must not wait for them to be
// compiled.
Result<void> Run::warm_up(const View& view) {
  for (const LiveQuality& other : live_qualities()) {
    if (other.method == quality().method) continue;
    const Result<std::optional<render::RenderedView>> drawn = view_.render(view, other, options_.renderer);
    if (!drawn) return forward(drawn);
  }
  return {};
}

void Run::judge(Timestamp time) {
  const std::size_t before = pace_.quality();
  const bool automatic = pace_.window() && warm(*pace_.window());
  if (pace_.judge(time, chain_.frame_rate(), automatic) && pace_.quality() != before)
    use_quality(pace_.fps());
}

void Run::listen(Timestamp time) {
  std::shared_ptr<const SilhouetteNews> news = chain_.silhouettes();
  std::vector<SilhouetteChange>& told = report_.silhouettes;
  if (!news || (told.empty() ? news->doubts.empty() : told.back().news == news)) return;
  // What was said already comes again once with its picture.
  if (!told.empty() && told.back().news->doubts == news->doubts)
    told.back().news = std::move(news);
  else
    told.push_back({at(time), std::move(news)});
}

void Run::measure(const LiveScene& scene, const double (&ms)[kStages], Timestamp done) {
  const double time = at(done) - kWarmUp;
  report_.shown.add(time);
  report_.latency.add(milliseconds_of(done - scene.scene.produced));
  for (int i = 0; i < kStages; ++i) report_.stages[static_cast<std::size_t>(i)].second.add(ms[i]);
}

Result<void> Run::picture(const std::shared_ptr<const LiveScene>& fresh, const ViewAt& view_at,
                          const std::function<Result<void>(const LivePicture&)>& visit) {
  const Timestamp begun = now();
  const bool first = !begun_;
  if (first) begun_ = begun;
  chain_.drawing(begun);
  const View view = view_at(at(begun));
  if (fresh) {
    if (Result<void> ok = view_.show(fresh); !ok) return ok;
  }
  const LiveScene& scene = *view_.scene();
  if (!scene.scene.mesh.empty())  // whose pictures an empty stage needs is anybody's guess
    chain_.want(render::needed_cameras(chain_.rig(), scene.scene.mesh, view, options_.renderer.cameras));
  if (first)
    if (Result<void> ok = warm_up(view); !ok) return ok;
  const Timestamp uploaded = now();
  Result<std::optional<render::RenderedView>> rendered = view_.render(view, quality(), options_.renderer);
  if (!rendered) return forward(rendered);
  const Timestamp drawn = now();
  LivePicture out{*rendered ? render::download(**rendered) : Image(options_.width, options_.height, 4), view,
                  &scene, at(begun), fresh == nullptr};
  const Timestamp done = now();
  chain_.drawn(done);
  if (warm(begun)) report_.pictures.add(at(done) - kWarmUp);
  pace_.drew(begun, done, fresh ? std::optional(milliseconds_of(done - scene.scene.produced)) : std::nullopt);
  if (fresh) {
    const SceneTimes& t = scene.times;
    const double ms[kStages] = {t.wait,
                                t.nodes,
                                t.hull,
                                milliseconds_of(begun - scene.ready),
                                milliseconds_of(uploaded - begun),
                                milliseconds_of(drawn - uploaded),
                                milliseconds_of(done - drawn),
                                t.key,
                                t.outline,
                                t.tile};
    if (warm(begun)) measure(scene, ms, done);
  }
  judge(done);
  return visit ? visit(out) : Result<void>();
}

Result<LiveReport> Run::draw(const ViewAt& view_at, const std::function<bool()>& stop,
                             const std::function<Result<void>(const LivePicture&)>& visit) {
  use_quality(0);
  const Nanoseconds patience{std::llround(1e9 / options_.view_fps)};
  Timestamp last = now();
  const Timestamp opened = last;
  while (!stop()) {
    const Timestamp time = now();
    if (options_.seconds > 0 && !begun_ && seconds(time - opened) >= options_.seconds + kWarmUp) {
      chain_.end();
      const std::string why = chain_.remark();
      return fail(ErrorCode::Timeout, text("no scene came within ", options_.seconds + kWarmUp, " s",
                                           why.empty() ? "" : ": ", why));
    }
    if (options_.seconds > 0 && begun_ && at(time) >= options_.seconds + kWarmUp) break;
    if (!was_warm_ && warm(time)) {
      was_warm_ = true;
      at_warm_ = chain_.counters();
    }
    chain_.poll();
    listen(time);
    const std::shared_ptr<const LiveScene> fresh = chain_.newest(last + patience);
    last = now();
    if (!fresh && chain_.over()) break;
    if (!fresh && (view_.scene() == nullptr || chain_.working())) continue;
    if (Result<void> ok = picture(fresh, view_at, visit); !ok) return forward(ok);
  }
  report_.seconds = std::max(at(now()) - kWarmUp, 0.0);
  if (options_.seconds > 0) report_.seconds = std::min(report_.seconds, options_.seconds);
  chain_.end();
  report_.counters = chain_.counters();
  return std::move(report_);
}

}  // namespace

Result<LiveReport> run_live(SceneFeed& scenes, const LiveRunOptions& options, const ViewAt& view_at,
                            const std::function<bool()>& stop,
                            const std::function<Result<void>(const LivePicture&)>& visit) {
  if (options.quality >= live_qualities().size())
    return fail(ErrorCode::InvalidArgument,
                text("live quality ", options.quality, "; there are 0 to ", live_qualities().size() - 1));
  if (!(options.view_fps > 0))
    return fail(ErrorCode::InvalidArgument, "the view needs a rate above 0 pictures a second");
  if (Result<void> ok = check(options.renderer); !ok) return forward(ok);
  Run run(scenes, options);
  return run.draw(view_at, stop, visit);
}

Result<LiveReport> run_live(LiveSource& source, const LiveChainOptions& chain_options,
                            const LiveRunOptions& options, const ViewAt& view_at,
                            const std::function<bool()>& stop,
                            const std::function<Result<void>(const LivePicture&)>& visit) {
  Result<std::unique_ptr<LiveChain>> chain = LiveChain::make(source, chain_options);
  if (!chain) return forward(chain);
  (*chain)->begin();
  return run_live(**chain, options, view_at, stop, visit);
}

}  // namespace floatstage::studio
