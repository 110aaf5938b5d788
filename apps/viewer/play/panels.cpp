#include "apps/viewer/play/panels.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "apps/viewer/window/layout.h"
#include "apps/viewer/window/transport.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

void choose(const char* label, const std::vector<std::string>& names, int& chosen) {
  if (!ImGui::BeginCombo(label, names[static_cast<std::size_t>(chosen)].c_str())) return;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (ImGui::Selectable(names[i].c_str(), chosen == static_cast<int>(i))) chosen = static_cast<int>(i);
  ImGui::EndCombo();
}

// What a side shows, of all that its method has; `first`: another choice before these, for which it is
// absent.
void choose_output(const char* label, const std::string& method, const char* first,
                   std::optional<render::RenderOutput>& output) {
  const std::vector<std::string>& names = render::render_output_names();
  const char* now = output ? names[static_cast<std::size_t>(*output)].c_str() : first;
  if (!ImGui::BeginCombo(label, now)) return;
  if (first != nullptr && ImGui::Selectable(first, !output)) output.reset();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto one = static_cast<render::RenderOutput>(i);
    if (render::can_show(method, one) && ImGui::Selectable(names[i].c_str(), output == one)) output = one;
  }
  ImGui::EndCombo();
}

// A camera of the take, or none: then the renderer chooses.
void choose_camera(const char* label, const std::vector<std::string>& serials, int& camera) {
  const char* now = camera < 0 ? "the view's first" : serials[static_cast<std::size_t>(camera)].c_str();
  if (!ImGui::BeginCombo(label, now)) return;
  if (ImGui::Selectable("the view's first", camera < 0)) camera = -1;
  for (std::size_t i = 0; i < serials.size(); ++i)
    if (ImGui::Selectable(serials[i].c_str(), camera == static_cast<int>(i))) camera = static_cast<int>(i);
  ImGui::EndCombo();
}

void draw_outputs(PlayerState& state) {
  const auto method = [&](int side) { return state.methods[static_cast<std::size_t>(side)]; };
  std::optional<render::RenderOutput> left = state.renderer.output;
  choose_output(state.split ? "left shows" : "show", method(state.left), nullptr, left);
  state.renderer.output = *left;
  if (!render::can_show(method(state.left), state.renderer.output))  // another method was chosen
    state.renderer.output = render::RenderOutput::Color;
  if (state.split) choose_output("right shows", method(state.right), "the same", state.right_output);
  if (state.right_output && !render::can_show(method(state.right), *state.right_output))
    state.right_output.reset();
  if (state.split || state.renderer.output != render::RenderOutput::Color) {
    choose_camera("camera", state.serials, state.renderer.shown_camera);
    choose_camera("towards", state.serials, state.renderer.towards_camera);
  }
}

void draw_methods(PlayerState& state) {
  choose(state.split ? "left" : "method", state.methods, state.left);
  bool split = state.split;
  if (ImGui::Checkbox("split screen (X)", &split)) state.toggle_split();
  if (state.split) {
    choose("right", state.methods, state.right);
    ImGui::SliderFloat("split at", &state.split_at, 0.02f, 0.98f, "%.2f");
  }
  draw_outputs(state);
  ImGui::SliderInt("photographs", &state.renderer.cameras, 1, 6);
  float radius = static_cast<float>(state.renderer.soft_radius);
  if (ImGui::SliderFloat("soft radius", &radius, 0, 32, "%.0f px")) state.renderer.soft_radius = radius;
  ImGui::SliderFloat("resolution", &state.render_scale, 0.25f, 1, "%.2f");
  ImGui::ColorEdit3("background", state.renderer.background.data(), ImGuiColorEditFlags_NoInputs);
}

void draw_sound(PlayerState& state) {
  ImGui::Checkbox("mute (V)", &state.muted);
  ImGui::SliderFloat("volume", &state.volume, 0.05f, 2, "%.2f");
  if (state.sounds.size() > 1) choose("track", state.sounds, state.sound);
}

// One drag of a slider is one step of undo.
void one_step(PlayerState& state) {
  if (ImGui::IsItemActivated()) state.path.begin_gesture();
  if (ImGui::IsItemDeactivated()) state.path.end_gesture();
}

void draw_key(PlayerState& state, std::size_t index) {
  pipeline::PathKey key = state.path.path().keys[index];
  auto time = static_cast<float>(key.time);
  if (ImGui::DragFloat("film", &time, 0.02f, 0, 0, "%.2f s"))
    state.path.move(index, static_cast<double>(time));
  one_step(state);
  if (const double rate = state.time.rate(); rate > 0) {
    bool holds = key.take_time.has_value();
    const double shown = take_time(state.path.path(), key.time);
    if (ImGui::Checkbox("##holds", &holds))
      key.take_time = holds ? std::optional(std::max(0.0, shown)) : std::nullopt;
    ImGui::SameLine();
    int frame = static_cast<int>(std::lround(shown * rate));
    ImGui::SetNextItemWidth(126 * ui_scale());
    if (ImGui::SliderInt("take", &frame, 0, state.time.frames() - 1, "frame %d"))
      key.take_time = frame / rate;
    one_step(state);
  }
  for (auto [name, member] :
       {std::pair{"ease in", &pipeline::PathKey::ease_in}, {"ease out", &pipeline::PathKey::ease_out}}) {
    auto ease = static_cast<float>(key.*member);
    if (ImGui::SliderFloat(name, &ease, 0, 1, "%.2f")) key.*member = static_cast<double>(ease);
    one_step(state);
  }
  bool orbits = key.orbit.has_value(), follows = key.follow;
  if (ImGui::Checkbox("orbit to the next", &orbits)) key.orbit = orbits ? std::optional(0) : std::nullopt;
  if (key.orbit && ImGui::InputInt("more turns", &*key.orbit)) key.orbit = std::clamp(*key.orbit, -99, 99);
  const pipeline::PathKey view = state.camera.key();
  if (ImGui::Button("set to this view")) {
    const Eigen::Vector3d from =
        key.follow ? state.track.at(take_time(state.path.path(), key.time)) : Eigen::Vector3d::Zero();
    key.eye = view.eye - from, key.target = view.target - from, key.up = view.up, key.fov_y = view.fov_y;
  }
  state.path.change(index, key);
  if (!state.track.centres.empty() && ImGui::Checkbox("follows the subject", &follows))
    state.path.set_follow(index, follows, state.track);
}

void draw_path(PlayerState& state, PanelRequests& requests, int film_pictures) {
  if (ImGui::Button("add key (K)")) state.add_key();
  ImGui::SameLine();
  if (ImGui::Button("clear")) state.path.clear(), state.follow_path = false;
  ImGui::SameLine();
  if (ImGui::Button("undo") && state.path.can_undo()) state.path.undo();
  ImGui::SameLine();
  if (ImGui::Button("redo") && state.path.can_redo()) state.path.redo();
  if (state.time.rate() > 0) ImGui::Checkbox("new keys hold the take", &state.keys_hold_take);
  const std::vector<pipeline::PathKey> keys =
      state.path.path().keys;  // a copy: buttons below change the path
  if (ImGui::BeginChild("keys", ImVec2(0, 84 * ui_scale()), true)) {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::Selectable(text("key ", i, " at ", keys[i].time, " s").c_str(), state.path.selected() == i,
                            0, ImVec2(170 * ui_scale(), 0)))
        show_key(i, state);
      ImGui::SameLine();
      if (ImGui::SmallButton("x")) state.path.remove(i);
      ImGui::PopID();
    }
  }
  ImGui::EndChild();
  if (const std::optional<std::size_t> selected = state.path.selected()) draw_key(state, *selected);
  if (!state.path.empty()) {
    ImGui::Checkbox("follow the path", &state.follow_path);
    float t = static_cast<float>(state.path_time);
    if (ImGui::SliderFloat("path time", &t, 0, static_cast<float>(state.path.path().duration()), "%.2f s"))
      state.path_time = t, state.follow_path = true, state.seek_by_path();
  } else {
    state.follow_path = false;
  }
  ImGui::InputText("path file", &state.path_file);
  requests.save_path = ImGui::Button("save");
  ImGui::SameLine();
  requests.load_path = ImGui::Button("load");
  ImGui::InputText("film", &state.film_file);
  if (film_pictures >= 0)
    ImGui::Text("rendering: %d pictures", film_pictures);
  else
    requests.render_film = ImGui::Button("render this path");
}

bool draw_who(PlayerState& state) {
  bool changed = false;
  for (PlayerState::Who& who : state.who) changed |= ImGui::Checkbox(who.label.c_str(), &who.shown);
  return changed;
}

}  // namespace

PanelRequests draw_controls(PlayerState& state, double render_milliseconds, int film_pictures) {
  PanelRequests requests;
  ImGui::PushItemWidth(150 * ui_scale());
  if (ImGui::CollapsingHeader("Picture", ImGuiTreeNodeFlags_DefaultOpen)) draw_methods(state);
  if (!state.who.empty() && ImGui::CollapsingHeader("Who is seen", ImGuiTreeNodeFlags_DefaultOpen))
    requests.who = draw_who(state);
  if (ImGui::CollapsingHeader("Camera", ImGuiTreeNodeFlags_DefaultOpen)) {
    ImGui::Checkbox("show the cameras (C)", &state.show_cameras);
    requests.home = ImGui::Button("home (H)");
    ImGui::TextDisabled("drag: orbit   shift: pan\nright: look   wheel: zoom\nWASD QE: fly");
  }
  if (!state.sounds.empty() && ImGui::CollapsingHeader("Sound", ImGuiTreeNodeFlags_DefaultOpen))
    draw_sound(state);
  if (ImGui::CollapsingHeader("Camera path", ImGuiTreeNodeFlags_DefaultOpen))
    draw_path(state, requests, film_pictures);
  ImGui::Separator();
  ImGui::Text("%.0f ms a picture (F3: more)", render_milliseconds);
  ImGui::PopItemWidth();
  return requests;
}

void apply_camera_requests(const PanelRequests& requests, const pipeline::PathKey& home, PlayerState& state) {
  if (requests.home) state.camera.set(home);
  if (requests.save_path) {
    const Result<void> ok = pipeline::save_path(state.path.path(), state.path_file);
    state.status = ok ? text("saved ", state.path_file) : ok.error().message;
  }
  if (requests.load_path) {
    Result<pipeline::CameraPath> path = state.track.centres.empty()
                                            ? pipeline::load_path_without_take(state.path_file)
                                            : pipeline::load_path(state.path_file);
    state.status = path ? text("loaded ", state.path_file) : path.error().message;
    if (path) state.path.set(std::move(*path));
  }
}

void draw_time_line(PlayerState& state, PathStrip& strip) {
  TimeLine& time = state.time;
  draw_transport(time);
  ImGui::Checkbox("loop", &time.loop);
  ImGui::SameLine();
  float speed = static_cast<float>(time.speed);
  ImGui::SetNextItemWidth(110 * ui_scale());
  if (ImGui::SliderFloat("##speed", &speed, 0.1f, 2, "speed %.1f")) time.speed = speed;
  ImGui::SameLine();
  int frame = time.frame();
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderInt("##frame", &frame, 0, time.frames() - 1, "frame %d")) time.seek(frame);
  if (!state.path.empty()) {
    const ImVec2 corner = ImGui::GetCursorScreenPos(),
                 size(ImGui::GetContentRegionAvail().x, PathStrip::kHeight * ui_scale());
    ImGui::InvisibleButton("path strip", size);
    strip.set_area(corner.x, corner.y, size.x, size.y, ui_scale());
    strip.draw(state);
  }
  ImGui::TextUnformatted(state.status.c_str());
}

}  // namespace floatstage::apps
