#include "apps/viewer/play/canvas.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

#include <imgui.h>

#include "studio/live/live_view.h"

namespace floatstage::apps {
namespace {

ImTextureID texture_id(unsigned texture) {
  return reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture));
}

bool same(const pipeline::PathKey& a, const pipeline::PathKey& b) {
  return a.eye == b.eye && a.target == b.target && a.up == b.up && a.fov_y == b.fov_y;
}

bool same(const render::RendererOptions& a, const render::RendererOptions& b) {
  return a.cameras == b.cameras && a.soft_radius == b.soft_radius && a.flow == b.flow && a.sharp == b.sharp &&
         a.background == b.background && a.output == b.output;
}

}  // namespace

Result<void> Canvas::show(const std::shared_ptr<const SceneFrame>& scene) {
  if (!scene || scene == scene_) return {};
  if (Result<void> ok = drawn_.set(rig_, *scene); !ok) return ok;
  scene_ = scene;
  ++shown_;
  drawable_ = true;
  frusta_.upload(scene->images);
  return {};
}

Result<void> Canvas::show(const studio::LiveScene& scene) {
  ++shown_;
  Result<bool> uploaded = studio::set_scene(scene, rig_, drawn_);
  drawable_ = uploaded && *uploaded;
  return uploaded ? Result<void>() : forward(uploaded);
}

bool Canvas::stale(const PlayerState& state, const pipeline::PathKey& key, int width, int height) const {
  return !made_ || made_->width != width || made_->height != height || made_->left != state.left ||
         made_->right != (state.split ? state.right : -1) || made_->scene != shown_ ||
         !same(made_->key, key) || !same(made_->renderer, state.renderer);
}

Result<void> Canvas::render_side(Side& side, int method, const PlayerState& state, const View& view) {
  Result<render::RenderedView> rendered =
      renderers_.render(state.methods[static_cast<std::size_t>(method)], drawn_, view, state.renderer);
  if (!rendered) return forward(rendered);
  side.view = *rendered;
  if (rendered->picture != nullptr) side.copy.show(*rendered->picture);
  side.texture = rendered->picture != nullptr ? side.copy.id() : rendered->texture;
  return {};
}

Result<void> Canvas::render(const PlayerState& state, const pipeline::PathKey& key, int width, int height) {
  const auto begin = std::chrono::steady_clock::now();
  // Recorded before rendering: a view that cannot be rendered is not tried again until something changes.
  made_ = Made{width, height, state.left, state.split ? state.right : -1, shown_, key, state.renderer};
  const View view = pipeline::view_of(key, width, height, subject_);
  view_ = view;
  if (Result<void> ok = render_side(left_, state.left, state, view); !ok) return ok;
  if (state.split)
    if (Result<void> ok = render_side(right_, state.right, state, view); !ok) return ok;
  render_milliseconds_ =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return {};
}

void Canvas::take_mouse(PlayerState& state, float width, float height) {
  const ImGuiIO& io = ImGui::GetIO();
  const double dx = io.MouseDelta.x / height, dy = io.MouseDelta.y / height;
  constexpr double kTurn = 3;  // radians for a drag over the picture's height
  if (ImGui::IsItemActive() && ImGui::IsMouseDragging(ImGuiMouseButton_Left)) {
    if (state.split && io.KeyCtrl)
      state.split_at = std::clamp(state.split_at + io.MouseDelta.x / width, 0.02f, 0.98f);
    else if (io.KeyShift)
      state.camera.pan(-dx, dy);
    else
      state.camera.orbit(-dx * kTurn, dy * kTurn);
  }
  if (ImGui::IsItemActive() && ImGui::IsMouseDragging(ImGuiMouseButton_Right))
    state.camera.look(dx * kTurn, -dy * kTurn);
  if (ImGui::IsItemActive() && ImGui::IsMouseDragging(ImGuiMouseButton_Middle)) state.camera.pan(-dx, dy);
  if (ImGui::IsItemHovered() && io.MouseWheel != 0) state.camera.zoom(std::pow(1.1, io.MouseWheel));
  if (io.WantTextInput) return;
  const double step = io.DeltaTime * (subject_.isEmpty() ? 1.0 : subject_.diagonal().norm());
  auto held = [](char key) { return ImGui::IsKeyDown(static_cast<int>(key)); };
  state.camera.fly(step * (held('D') - held('A')), step * (held('E') - held('Q')),
                   step * (held('W') - held('S')));
}

Result<void> Canvas::draw(PlayerState& state) {
  const ImVec2 size = ImGui::GetContentRegionAvail(), origin = ImGui::GetCursorScreenPos();
  if (size.x < 8 || size.y < 8) return {};
  ImGui::InvisibleButton("canvas", size,
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  if (!state.follow_path) take_mouse(state, size.x, size.y);
  if (!drawable_) return {};

  const pipeline::PathKey key = state.follow_path && !state.path.empty()
                                    ? pipeline::sample(state.path.path(), state.path_time)
                                    : state.camera.key();
  const int width = std::max(1, static_cast<int>(std::lround(size.x * state.render_scale)));
  const int height = std::max(1, static_cast<int>(std::lround(size.y * state.render_scale)));
  Result<void> rendered;
  if (stale(state, key, width, height)) rendered = render(state, key, width, height);

  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 end(origin.x + size.x, origin.y + size.y);
  const float middle = state.split ? state.split_at : 1.f, x = origin.x + size.x * middle;
  if (left_.texture != 0)
    list->AddImage(texture_id(left_.texture), origin, ImVec2(x, end.y), {0, 0}, {middle, 1});
  if (state.split && right_.texture != 0) {
    list->AddImage(texture_id(right_.texture), ImVec2(x, origin.y), end, {middle, 0}, {1, 1});
    list->AddLine(ImVec2(x, origin.y), ImVec2(x, end.y), IM_COL32(255, 190, 60, 255), 1.5f);
    const std::string& name = state.methods[static_cast<std::size_t>(state.left)];
    list->AddText(ImVec2(x - 10 - ImGui::CalcTextSize(name.c_str()).x, origin.y + 8), IM_COL32_WHITE,
                  name.c_str());
    list->AddText(ImVec2(x + 10, origin.y + 8), IM_COL32_WHITE,
                  state.methods[static_cast<std::size_t>(state.right)].c_str());
  }
  if (state.show_cameras) {
    const double depth = subject_.isEmpty() ? 0.3 : subject_.diagonal().norm() * 0.15;
    list->PushClipRect(origin, end, true);
    frusta_.draw(list, origin, size.x / static_cast<float>(width), rig_,
                 pipeline::view_of(key, width, height, subject_), depth, left_.view.cameras);
    list->PopClipRect();
  }
  return rendered;
}

}  // namespace floatstage::apps
