#include "apps/viewer/play/canvas.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include <imgui.h>

#include "core/text.h"
#include "studio/live/live_view.h"

namespace floatstage::apps {
namespace {

ImTextureID texture_id(unsigned texture) {
  return reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture));
}

// The method that blends where one floats: the same photographs without their flow, if it has what is shown.
int blended(const PlayerState& state, int method, render::RenderOutput output) {
  if (method < 0 || state.methods[static_cast<std::size_t>(method)] != "floating" ||
      !render::can_show("linear", output))
    return method;
  const auto linear = std::find(state.methods.begin(), state.methods.end(), "linear");
  return linear == state.methods.end() ? method : static_cast<int>(linear - state.methods.begin());
}

// What stands above a side of the split.
std::string side_name(const PlayerState& state, int method, render::RenderOutput output) {
  const std::string& name = state.methods[static_cast<std::size_t>(method)];
  if (output == render::RenderOutput::Color) return name;
  return name + ": " + render::render_output_names()[static_cast<std::size_t>(output)];
}

bool is_shown(const PlayerState& state, const char* method) {
  const auto is = [&](int shown) { return state.methods[static_cast<std::size_t>(shown)] == method; };
  return is(state.left) || (state.split && is(state.right));
}

bool same(const pipeline::PathKey& a, const pipeline::PathKey& b) {
  return a.eye == b.eye && a.target == b.target && a.up == b.up && a.fov_y == b.fov_y;
}

bool same(const render::RendererOptions& a, const render::RendererOptions& b) {
  return a.cameras == b.cameras && a.soft_radius == b.soft_radius && a.flow == b.flow &&
         a.positions == b.positions && a.alignment == b.alignment && a.field_memory == b.field_memory &&
         a.sharp == b.sharp && a.background == b.background && a.output == b.output &&
         a.shown_camera == b.shown_camera && a.towards_camera == b.towards_camera;
}

}  // namespace

Result<void> Canvas::show(const std::shared_ptr<const SceneFrame>& scene) {
  if (!scene || scene == scene_) return {};
  const auto begin = std::chrono::steady_clock::now();
  if (Result<void> ok = drawn_.set(rig_, *scene); !ok) return ok;
  times_.load_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  scene_ = scene;
  ++shown_;
  drawable_ = true;
  frusta_.upload(scene->images);
  return {};
}

Result<void> Canvas::show(const studio::LiveScene& scene) {
  ++shown_;
  Result<bool> uploaded = studio::set_scene(scene, rig_, tiles_, drawn_);
  drawable_ = uploaded && *uploaded;
  return uploaded ? Result<void>() : forward(uploaded);
}

bool Canvas::stale(const Made& wanted) const {
  return !made_ || gave_up_ || made_->width != wanted.width || made_->height != wanted.height ||
         made_->left != wanted.left || made_->right != wanted.right ||
         made_->right_output != wanted.right_output || made_->scene != wanted.scene ||
         !same(made_->key, wanted.key) || !same(made_->renderer, wanted.renderer);
}

Canvas::Made Canvas::wanted(const PlayerState& state, const pipeline::PathKey& key, float width, float height,
                            bool moving) const {
  const double scale = state.render_scale * (moving ? pace_.scale() : 1);
  const auto pixels = [&](float side) { return std::max(1, static_cast<int>(std::lround(side * scale))); };
  Made made{pixels(width),  pixels(height),
            state.left,     state.split ? state.right : -1,
            shown_,         key,
            state.renderer, state.right_output.value_or(state.renderer.output)};
  if (moving) {
    // Fields that stay are not made twice, once of each size.
    if (!is_shown(state, "floating-static"))
      made.renderer.flow.shrink = std::max(2, made.renderer.flow.shrink);
    made.renderer.soft_radius *= pace_.scale();
    if (pace_.without_flow()) {
      made.left = blended(state, made.left, made.renderer.output);
      made.right = blended(state, made.right, made.right_output);
    }
  }
  return made;
}

/// Whether the camera or time moves, by itself or by a key, or a hand has just begun something. Another
/// option is drawn in full at once, and a GPU draws all in full.
bool Canvas::judge_motion(const PlayerState& state, const pipeline::PathKey& key, double now) {
  if (!state.quick || state.renderer.back_end == render::BackEnd::Gl) return false;
  if (gave_up_ || (made_ && (!same(made_->key, key) || made_->scene != shown_))) pace_.moved(now);
  return pace_.moving(now);
}

// Milliseconds that it took.
Result<double> Canvas::render_side(Side& side, int method, render::RenderOutput output,
                                   const PlayerState& state, bool moving) {
  const auto begin = std::chrono::steady_clock::now();
  render::RendererOptions options = made_->renderer;
  options.output = output;
  if (hand_waits_ && state.quick && left_.texture != 0)
    options.given_up = [this, moving] { return hand_waits_() && !moving; };
  Result<render::RenderedView> rendered =
      renderers_.render(state.methods[static_cast<std::size_t>(method)], drawn_, *view_, options);
  if (!rendered) return forward(rendered);
  side.view = *rendered;
  if (rendered->picture != nullptr) side.copy.show(*rendered->picture);
  side.texture = rendered->picture != nullptr ? side.copy.id() : rendered->texture;
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

Result<void> Canvas::render_sides(const PlayerState& state, bool moving) {
  const Result<double> left = render_side(left_, made_->left, made_->renderer.output, state, moving);
  if (!left) return forward(left);
  if (keep_pictures_) kept_ = render::download(left_.view);
  const bool one = made_->left == made_->right &&  // in motion both sides may be blended
                   made_->renderer.output == made_->right_output;
  const Result<double> right = state.split && !one
                                   ? render_side(right_, made_->right, made_->right_output, state, moving)
                                   : Result<double>(0.0);
  if (!right) return forward(right);
  if (state.split && one) right_.view = left_.view, right_.texture = left_.texture;
  times_.left_ms = *left, times_.right_ms = *right;
  return {};
}

Result<void> Canvas::render(const PlayerState& state, const Made& wanted, bool moving, double now) {
  const auto begin = std::chrono::steady_clock::now();
  // Recorded before rendering: a view that cannot be rendered is not tried again until something changes.
  made_ = wanted;
  sight_.reset();
  view_ = pipeline::view_of(wanted.key, wanted.width, wanted.height, subject_);
  const Result<void> drawn = render_sides(state, moving);
  gave_up_ = !drawn && drawn.error().code == ErrorCode::Cancelled;
  if (gave_up_) ++times_.given_up;
  if (!drawn) return gave_up_ ? Result<void>() : drawn;
  times_.width = wanted.width, times_.height = wanted.height;
  last_render_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  render_milliseconds_ = 1e3 * last_render_seconds_;
  (moving ? times_.moving : times_.at_rest).add(render_milliseconds_);
  if (moving) {
    if (made_moving_) times_.moving_seconds += now - last_moving_, ++times_.moving_steps;
    times_.coarsest = std::min(times_.coarsest, pace_.scale());
    times_.without_flow = times_.without_flow || pace_.without_flow();
    pace_.drew(last_render_seconds_);
  } else {
    pace_.stood(last_render_seconds_);
  }
  made_moving_ = moving;
  last_moving_ = now;
  return {};
}

/// Keys that are held fly; one that was tapped between two pictures counts for this one.
void Canvas::fly(std::span<const InputEvent> input, PlayerState& state) const {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) return;
  const double step = io.DeltaTime * (subject_.isEmpty() ? 1.0 : subject_.diagonal().norm());
  const auto held = [&](char key) {
    return ImGui::IsKeyDown(static_cast<int>(key)) ||
           std::any_of(input.begin(), input.end(), [&](const InputEvent& e) {
             return e.kind == InputEvent::Kind::Key && e.key == key && !e.control;
           });
  };
  state.camera.fly(step * (held('D') - held('A')), step * (held('E') - held('Q')),
                   step * (held('W') - held('S')));
}

void Canvas::list_pictures(const PlayerState& state, float x0, float y0, float x1, float y1) const {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float middle = state.split ? state.split_at : 1.f, x = x0 + (x1 - x0) * middle;
  if (left_.texture != 0) list->AddImage(texture_id(left_.texture), {x0, y0}, {x, y1}, {0, 0}, {middle, 1});
  if (!state.split || right_.texture == 0) return;
  list->AddImage(texture_id(right_.texture), {x, y0}, {x1, y1}, {middle, 0}, {1, 1});
  list->AddLine({x, y0}, {x, y1}, IM_COL32(255, 190, 60, 255), 1.5f);
  const std::string left = side_name(state, state.left, state.renderer.output);
  list->AddText({x - 10 - ImGui::CalcTextSize(left.c_str()).x, y0 + 8}, IM_COL32_WHITE, left.c_str());
  list->AddText({x + 10, y0 + 8}, IM_COL32_WHITE,
                side_name(state, state.right, state.right_output.value_or(state.renderer.output)).c_str());
}

/// What the picture lacks, in the lower left corner.
void Canvas::list_doubts(float x0, float y1) const {
  ImDrawList* list = ImGui::GetWindowDrawList();
  float line = y1 - 24;
  const auto say = [&](const std::string& doubt) {
    list->AddText({x0 + 10, line}, IM_COL32(255, 190, 60, 255), doubt.c_str());
    line -= ImGui::GetTextLineHeightWithSpacing();
  };
  if (render::lacks_shown_camera(left_.view, made_->renderer))
    say("this view is not drawn from the shown camera: nearer to it, or with more photographs, it is");
  if (sight_ && sight_->much > 0)
    say(text("none of its photographs sees ", std::lround(100 * sight_->worst),
             " % of this view: it continues what is around there"));
}

/// Where the time goes, in the upper right corner.
void Canvas::list_times(const PlayerState& state, float x1, float y0) const {
  const auto method = [&](int i) { return state.methods[static_cast<std::size_t>(i)].c_str(); };
  char lines[256];
  const int n = std::snprintf(lines, sizeof lines, "%-10s %6.1f ms\n", method(made_->left), times_.left_ms);
  int end = n;
  if (state.split)
    end += std::snprintf(lines + end, sizeof lines - static_cast<std::size_t>(end), "%-10s %6.1f ms\n",
                         method(made_->right), times_.right_ms);
  std::snprintf(lines + end, sizeof lines - static_cast<std::size_t>(end),
                "%-10s %6.1f ms\n%-10s %6.1f ms\n%d x %d%s", "window", times_.window_ms, "scene",
                times_.load_ms, times_.width, times_.height, made_moving_ ? ", moving" : "");
  const ImVec2 size = ImGui::CalcTextSize(lines);
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled({x1 - size.x - 24, y0 + 8}, {x1 - 8, y0 + size.y + 20}, IM_COL32(0, 0, 0, 160), 4);
  list->AddText({x1 - size.x - 16, y0 + 14}, IM_COL32_WHITE, lines);
}

Result<void> Canvas::draw(PlayerState& state, std::span<const InputEvent> input) {
  last_render_seconds_ = 0;
  const ImVec2 size = ImGui::GetContentRegionAvail(), origin = ImGui::GetCursorScreenPos();
  if (size.x < 8 || size.y < 8) return {};
  ImGui::InvisibleButton("canvas", size,
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  hands_.set_area(origin.x, origin.y, size.x, size.y);
  hands_.take(input, !state.follow_path, state);
  if (!state.follow_path) fly(input, state);
  if (!drawable_) return {};

  const pipeline::PathKey key = state.follow_path && !state.path.empty()
                                    ? pipeline::sample(state.path.path(), state.path_time, state.track)
                                    : state.camera.key();
  const double now = ImGui::GetTime();
  const bool moving = judge_motion(state, key, now);
  const Made made = wanted(state, key, size.x, size.y, moving);
  Result<void> rendered;
  const bool renews = stale(made);
  if (renews) rendered = render(state, made, moving, now);
  // A GPU is asked once the picture stands, for it would be waited for.
  if (!sight_ && (!renews || left_.view.picture != nullptr))
    sight_.emplace().add(0, render::seen_pixels(left_.view));

  list_pictures(state, origin.x, origin.y, origin.x + size.x, origin.y + size.y);
  if (made_) list_doubts(origin.x, origin.y + size.y);
  if (state.show_times && made_) list_times(state, origin.x + size.x, origin.y);
  if (state.show_cameras) {
    const double depth = subject_.isEmpty() ? 0.3 : subject_.diagonal().norm() * 0.15;
    ImDrawList* list = ImGui::GetWindowDrawList();
    list->PushClipRect(origin, {origin.x + size.x, origin.y + size.y}, true);
    frusta_.draw(list, origin, size.x / static_cast<float>(made.width), rig_,
                 pipeline::view_of(key, made.width, made.height, subject_), depth, left_.view.cameras);
    list->PopClipRect();
  }
  return rendered;
}

}  // namespace floatstage::apps
