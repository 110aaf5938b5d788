#include "apps/viewer/detail/zoom_window.h"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include <imgui.h>

#include "apps/viewer/detail/zoom_panel.h"
#include "apps/viewer/window/layout.h"
#include "apps/viewer/window/screenshot.h"
#include "apps/viewer/window/window.h"
#include "core/png.h"

namespace floatstage::apps {
namespace {

using Eigen::Vector2d;

constexpr float kStrip = 28;  // px before ui_scale()
constexpr std::array<float, 3> kBackground = {0.16F, 0.17F, 0.19F};
constexpr double kClosest = 32;                    // window px a px of the finest photograph
constexpr double kStep = 1.01;                     // of a flight, a picture
constexpr std::size_t kLoadedAPicture = 16 << 20;  // bytes: some ten milliseconds of a bus
constexpr float kTint = 0.55F;                     // of the picture that its provenance hides

class ZoomWindow {
 public:
  ZoomWindow(const ZoomScene& scene, const ZoomWindowOptions& options)
      : scene_(scene),
        options_(options),
        state_{.fit = PictureFit(scene.width, scene.height,
                                 kClosest * scene.zipmap->finest() *
                                     std::max(1.0, std::max(scene.width, scene.height) / 256.0)),
               .split = options.split,
               .provenance = options.provenance,
               .graph = options.graph,
               .status =
                   "wheel: zoom to the cursor   drag: pan   Ctrl-drag: move the split   F12: screenshot"} {}

  Result<void> open() {
    Result<std::unique_ptr<Window>> window = Window::open(options_.title, options_.width, options_.height);
    if (!window) return forward(window);
    window_ = std::move(*window);
    Result<std::unique_ptr<render::GlZipmap>> zipmap =
        render::GlZipmap::make(scene_.zipmap, {.budget = options_.budget});
    if (!zipmap) return forward(zipmap);
    zipmap_ = std::move(*zipmap);
    return {};
  }

  Result<void> run() {
    constexpr double kIdle = 0.1;     // seconds to sleep while nothing moves
    constexpr int kSettleFrames = 3;  // the user interface needs a few frames before its layout stands
    int settled = 0;
    while (!window_->should_close() && !(options_.stop && options_.stop())) {
      const bool rests = options_.screenshot.empty() && arrived_ && drawn_.waiting == 0;
      window_->begin_frame(rests ? kIdle : 0);
      const auto begun = std::chrono::steady_clock::now();
      const ZoomRequests requests = take_zoom_input(window_->take_input(), state_);
      Result<void> ok;
      lay_out_window(kStrip, kBackground,
                     {.controls = [&] { draw_zoom_controls(scene_, *zipmap_, drawn_, state_); },
                      .strip = [&] { ImGui::TextUnformatted(state_.status.c_str()); },
                      .stage = [&] { ok = draw_stage(); }});
      if (!ok) return ok;
      settled = arrived_ && drawn_.waiting == 0 ? settled + 1 : 0;
      const bool last = !options_.screenshot.empty() && settled >= kSettleFrames;
      Image picture;
      window_->end_frame(last || requests.screenshot ? &picture : nullptr);
      if (std::exchange(drew_, false))
        report_.pictures.add(1e3 *
                             std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
      if (last) return save_png(picture, options_.screenshot);
      if (requests.screenshot) {
        state_.status = keep_screenshot(picture);
        std::printf("%s\n", state_.status.c_str());
      }
    }
    return {};
  }

  ZoomReport report() const {
    ZoomReport r = report_;
    r.zoom = state_.fit.scale();
    r.allocated = zipmap_->allocated();
    r.flat = scene_.zipmap->bytes_when_flat();
    r.finest = scene_.zipmap->finest();
    r.layers = zipmap_->layers();
    r.passes = drawn_.passes;
    return r;
  }

 private:
  // The first frames: to where the options say, at once or step by step.
  void go() {
    if (arrived_) return;
    const Vector2d whole(scene_.width / 2.0, scene_.height / 2.0), goal = options_.at.value_or(whole);
    if (begin_ == 0) state_.fit.whole(), begin_ = state_.fit.scale();
    const double end = options_.zoom > 0 ? std::max(options_.zoom, begin_) : begin_;
    const double now = options_.fly ? std::min(end, begin_ * std::pow(kStep, report_.steps)) : end;
    arrived_ = now >= end;
    const double left = end > begin_ ? 1 - std::log(now / begin_) / std::log(end / begin_) : 0;
    state_.fit.look_at(goal + (whole - goal) * (left * begin_ / now), now);
    ++report_.steps;
  }

  Result<void> draw_stage() {
    const ImVec2 origin = ImGui::GetCursorScreenPos(), size = ImGui::GetContentRegionAvail();
    if (size.x < 8 || size.y < 8) return {};
    ImGui::InvisibleButton("canvas", size);
    state_.fit.set_area(origin.x, origin.y, size.x, size.y);
    state_.stage_x = origin.x, state_.stage_width = size.x;
    go();
    const int width = static_cast<int>(size.x), height = static_cast<int>(size.y);
    if (Result<void> ok = draw(width, height); !ok) return ok;
    show(origin, size);
    return {};
  }

  // Only when something has changed.
  Result<void> draw(int width, int height) {
    const PictureFit& fit = state_.fit;
    const Vector2d corner = fit.to_photograph(state_.stage_x, fit.top());
    render::ZipmapView view{Eigen::Matrix3d::Identity(), width, height, render::Zipmap::Wrap::Clamp};
    view.uv_from_pixel << 1 / fit.scale() / scene_.width, 0, corner.x() / scene_.width, 0,
        1 / fit.scale() / scene_.height, corner.y() / scene_.height, 0, 0, 1;
    render::ZipmapDrawing drawing;
    if (state_.split) drawing.plain_from = static_cast<int>(state_.split_at * width);
    if (state_.provenance) drawing.tints = scene_.provenance, drawing.tints.strength = kTint;
    if (options_.screenshot.empty()) drawing.most_loaded = kLoadedAPicture;
    const Made made{view.uv_from_pixel, width, height, drawing.plain_from, state_.provenance};
    if (made_ && *made_ == made && drawn_.waiting == 0) return {};
    Result<render::DrawnZipmap> drawn = zipmap_->draw(view, drawing);
    if (!drawn) return forward(drawn);
    drawn_ = *drawn;
    made_ = made;
    drew_ = true;
    return {};
  }

  // What of the stage shows the root: beyond it there is nothing.
  void show(const ImVec2& origin, const ImVec2& size) const {
    const Vector2d low = state_.fit.to_window({0, 0}).cwiseMax(Vector2d(origin.x, origin.y)),
                   high = state_.fit.to_window({scene_.width, scene_.height})
                              .cwiseMin(Vector2d(origin.x + size.x, origin.y + size.y));
    const auto at = [](const Vector2d& p) {
      return ImVec2(static_cast<float>(p.x()), static_cast<float>(p.y()));
    };
    const auto uv = [&](const Vector2d& p) {
      return ImVec2((static_cast<float>(p.x()) - origin.x) / std::floor(size.x),
                    (static_cast<float>(p.y()) - origin.y) / std::floor(size.y));
    };
    ImDrawList* list = ImGui::GetWindowDrawList();
    list->PushClipRect(origin, {origin.x + size.x, origin.y + size.y}, true);
    list->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(zipmap_->texture())), at(low),
                   at(high), uv(low), uv(high));
    if (state_.graph) draw_outlines(list, scene_, state_);
    if (state_.split) {
      const float x = origin.x + static_cast<float>(state_.split_at) * size.x;
      list->AddLine({x, origin.y}, {x, origin.y + size.y}, IM_COL32(255, 190, 60, 255), 1.5F);
      list->AddText({x + 10, origin.y + 8}, IM_COL32_WHITE, "the root enlarged");
      const char* left = "with its photographs";
      list->AddText({x - 10 - ImGui::CalcTextSize(left).x, origin.y + 8}, IM_COL32_WHITE, left);
    }
    list->PopClipRect();
  }

  struct Made {
    Eigen::Matrix3d uv_from_pixel;
    int width, height, plain_from;
    bool provenance;
    bool operator==(const Made&) const = default;
  };

  const ZoomScene& scene_;
  const ZoomWindowOptions& options_;
  ZoomState state_;
  std::unique_ptr<Window> window_;  // outlives what draws in it
  std::unique_ptr<render::GlZipmap> zipmap_;
  render::DrawnZipmap drawn_;
  std::optional<Made> made_;
  ZoomReport report_;
  bool drew_ = false;
  double begin_ = 0;  // scale of the whole; 0: not known yet
  bool arrived_ = false;
};

}  // namespace

Result<ZoomReport> show_zoom(const ZoomScene& scene, const ZoomWindowOptions& options) {
  ZoomWindow window(scene, options);
  if (Result<void> ok = window.open(); !ok) return forward(ok);
  if (Result<void> ok = window.run(); !ok) return forward(ok);
  return window.report();
}

}  // namespace floatstage::apps
