#include "apps/viewer/live/live_window.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <imgui.h>

#include "apps/viewer/live/live_panel.h"
#include "apps/viewer/play/canvas.h"
#include "apps/viewer/play/panels.h"
#include "apps/viewer/play/shown_texture.h"
#include "apps/viewer/play/stage_input.h"
#include "apps/viewer/window/layout.h"
#include "apps/viewer/window/window.h"
#include "core/log.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/film.h"
#include "pipeline/orbit.h"
#include "studio/live/live_pace.h"
#include "studio/messages/clock.h"

namespace floatstage::apps {
namespace {

constexpr float kStatusHeight = 28;
constexpr int kScenesBeforeScreenshot = 8;           // until then the needed textures have come
constexpr Nanoseconds kPatience = milliseconds(20);  // for a scene, before the window is drawn anyway

class LiveWindow {
 public:
  LiveWindow(studio::SceneFeed& feed, ControlModel& model, const LiveWindowOptions& options)
      : feed_(feed),
        model_(model),
        options_(options),
        home_(home_of(feed.rig())),
        canvas_(feed.rig(), {}),
        pace_(options.run.target_fps, options.run.quality),
        state_{TimeLine(1, 0), ViewerCamera(home_)} {
    for (const render::RendererInfo& r : render::renderers())
      if (!r.needs_grid) state_.methods.push_back(r.name);  // a studio's cameras stand around it
    state_.renderer = options.run.renderer;
    state_.show_cameras = options.show_cameras;
    state_.status = feed.description();
    state_.time.playing = true;
    use_quality(options.run.quality);
    canvas_.keep_pictures(options.stream != nullptr);
  }

  Result<void> follow(const std::filesystem::path& file) {
    Result<pipeline::CameraPath> path = pipeline::load_path_without_take(file);
    if (!path) return forward(path);
    state_.path.set(std::move(*path));
    state_.path_file = file.string();
    state_.follow_path = true;
    return {};
  }

  /// One frame of the user interface, with what hands did since the last. Errors are shown, not returned: the
  /// window stays.
  void frame(std::span<const InputEvent> input) {
    feed_.poll();
    const std::shared_ptr<const studio::LiveScene> fresh = feed_.newest(studio::now() + kPatience);
    const Timestamp begun = studio::now();
    feed_.drawing(begun);
    const bool shown = fresh && state_.time.playing;
    if (shown) show(fresh);
    if (state_.follow_path) advance_path(ImGui::GetIO().DeltaTime);
    take_shortcuts(input, home_, state_);
    lay_out(input);
    if (scene_ && !scene_->scene.mesh.empty()) {
      // Textures of other machines come only when they are asked for: before the first picture too.
      const View view = canvas_.view()
                            ? *canvas_.view()
                            : pipeline::view_of(home_, options_.run.width, options_.run.height, {});
      feed_.want(render::needed_cameras(feed_.rig(), scene_->scene.mesh, view, state_.renderer.cameras));
    }
    if (options_.stream != nullptr) send(shown);
    const Timestamp done = studio::now();
    feed_.drawn(done);
    pace_.drew(begun, done,
               shown ? std::optional(studio::milliseconds_of(done - fresh->scene.produced)) : std::nullopt);
    look_around(done);
  }
  bool stands() const { return shown_ >= kScenesBeforeScreenshot && canvas_.has_full_picture(); }

 private:
  // Between two cameras: at a camera every method shows its photograph.
  static pipeline::PathKey home_of(const Rig& rig) {
    return pipeline::sample(pipeline::orbit_around(rig, {}, {.seconds = 1}).path,
                            0.5 / static_cast<double>(rig.cameras.size()));
  }

  void advance_path(double seconds) {
    const double duration = state_.path.path().duration();
    if (duration > 0) state_.path_time = std::fmod(state_.path_time + seconds, duration);
  }

  void show(const std::shared_ptr<const studio::LiveScene>& fresh) {
    scene_ = fresh;
    ++shown_;
    if (Result<void> ok = canvas_.show(*fresh); !ok) state_.status = ok.error().message;
  }

  // An empty stage is a picture too.
  void send(bool fresh) {
    std::optional<Image> picture = canvas_.take_picture();
    if (!picture && fresh && !canvas_.has_subject()) picture = Image(16, 9, 4);
    if (picture)
      options_.stream->offer(pipeline::over(*picture, state_.renderer.background),
                             fresh ? std::optional(scene_->scene.produced) : std::nullopt);
    panel_.stream = stream_line();
  }

  std::string stream_line() const {
    const capture::StreamOutput::Health health = options_.stream->health();
    return text(health.connected ? "on air: " : "nobody receives: ", options_.stream->address(),
                health.trouble.empty() || health.connected ? "" : "\n",
                health.connected ? "" : health.trouble);
  }

  void use_quality(std::size_t level) {
    const studio::LiveQuality& quality = studio::live_qualities()[level];
    panel_.quality = level;
    feed_.set_quality(quality.node);
    state_.renderer.flow = quality.flow;
    state_.renderer.sharp = quality.sharp;
    state_.render_scale = 1.0F / static_cast<float>(quality.output);
    const auto method = std::find(state_.methods.begin(), state_.methods.end(), quality.method);
    if (method != state_.methods.end()) state_.left = static_cast<int>(method - state_.methods.begin());
    log::info(text("live quality at ", std::round(10 * pace_.fps()) / 10,
                   " scenes a second: ", studio::describe(quality)));
  }

  void look_around(Timestamp time) {
    if (!pace_.judge(time, feed_.frame_rate(), panel_.automatic && state_.time.playing)) return;
    panel_.fps = pace_.fps();
    panel_.latency_ms = pace_.latency_ms();
    panel_.remark = feed_.remark();
    show_doubts();
    if (feed_.over()) panel_.remark = "the source is over";
    if (pace_.quality() != panel_.quality) use_quality(pace_.quality());
  }

  void show_doubts() {
    const std::shared_ptr<const studio::SilhouetteNews> news = feed_.silhouettes();
    if (news == news_) return;
    news_ = news;
    panel_.doubts = 0;
    if (!news || news->picture.empty()) return;
    doubts_.show(news->picture);
    panel_.doubts = doubts_.id();
    panel_.doubts_shape = static_cast<float>(news->picture.height) / static_cast<float>(news->picture.width);
  }

  void draw_panels() {
    if (ImGui::CollapsingHeader("Studio", ImGuiTreeNodeFlags_DefaultOpen)) draw_live_panel(panel_, model_);
    if (panel_.quality != pace_.quality()) {
      pace_.choose(panel_.quality);
      use_quality(panel_.quality);
    }
    const PanelRequests requests = draw_controls(state_, canvas_.render_milliseconds(), -1);
    apply_camera_requests(requests, home_, state_);
    if (requests.render_film)
      state_.status = "a film is rendered of a take: record one, process it and play it";
  }

  void lay_out(std::span<const InputEvent> input) {
    panel_.hold = !state_.time.playing;
    lay_out_window(kStatusHeight, state_.renderer.background,
                   {.controls = [&] { draw_panels(); },
                    .strip = [&] { ImGui::TextUnformatted(state_.status.c_str()); },
                    .stage =
                        [&] {
                          if (Result<void> ok = canvas_.draw(state_, input); !ok)
                            state_.status = ok.error().message;
                        }});
    state_.time.playing = !panel_.hold;
  }

  studio::SceneFeed& feed_;
  ControlModel& model_;
  const LiveWindowOptions& options_;
  const pipeline::PathKey home_;
  Canvas canvas_;
  studio::LivePace pace_;
  PlayerState state_;
  LivePanelState panel_;
  ShownTexture doubts_;
  std::shared_ptr<const studio::SilhouetteNews> news_;
  std::shared_ptr<const studio::LiveScene> scene_;
  long shown_ = 0;
};

}  // namespace

Result<void> run_live_window(studio::SceneFeed& feed, ControlModel& model, const LiveWindowOptions& options) {
  if (options.run.quality >= studio::live_qualities().size())
    return fail(ErrorCode::InvalidArgument, text("live quality ", options.run.quality, "; there are 0 to ",
                                                 studio::live_qualities().size() - 1));
  Result<std::unique_ptr<Window>> window =
      Window::open("Floatstage live: " + feed.description(), options.run.width, options.run.height);
  if (!window) return forward(window);
  LiveWindowOptions here = options;
  here.run.renderer.back_end = render::back_end_in_window(options.run.renderer.back_end, (*window)->gl());
  LiveWindow live(feed, model, here);
  if (!options.path_file.empty())
    if (Result<void> ok = live.follow(options.path_file); !ok) return ok;
  const Timestamp begun = studio::now();
  Image picture;
  while (!(*window)->should_close() && !(options.stop && options.stop()) && picture.empty()) {
    if (options.run.seconds > 0 && seconds(studio::now() - begun) > options.run.seconds) break;
    (*window)->begin_frame(0);
    live.frame((*window)->take_input());
    (*window)->end_frame(!options.screenshot.empty() && live.stands() ? &picture : nullptr);
  }
  feed.end();
  if (!picture.empty()) return save_png(picture, options.screenshot);
  return {};
}

}  // namespace floatstage::apps
