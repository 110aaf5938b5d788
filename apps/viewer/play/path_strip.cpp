#include "apps/viewer/play/path_strip.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <imgui.h>

namespace floatstage::apps {
namespace {

constexpr double kGrip = 7;                // px around a handle that take it
constexpr double kRoom = 1.15;             // of the path's length: there is room to drag the last key to
constexpr double kLeft = 40, kRight = 10;  // px at the ends; names stand at the left

double take_seconds(const PlayerState& state) {
  return state.time.rate() > 0 ? (state.time.frames() - 1) / state.time.rate() : 0;
}

}  // namespace

void show_key(std::size_t index, PlayerState& state) {
  const pipeline::CameraPath& path = state.path.path();
  state.path.select(index);
  state.path_time = path.keys[index].time;
  state.camera.set(pipeline::sample(path, state.path_time, state.track));
  state.follow_path = false;
  state.seek_by_path();
}

void PathStrip::set_area(double x, double y, double width, double height, double scale) {
  x_ = x, y_ = y;
  width_ = std::max(100.0 * scale, width), height_ = std::max(1.0, height);
  scale_ = scale;
}

double PathStrip::length(Lane lane, const PlayerState& state) const {
  if (lane == Lane::Take) return std::max(1e-3, take_seconds(state));
  return held_length_ > 0 ? held_length_ : std::max(1.0, state.path.path().duration() * kRoom);
}

double PathStrip::x_of(Lane lane, double seconds, const PlayerState& state) const {
  return x_ + scale_ * kLeft + (width_ - scale_ * (kLeft + kRight)) * seconds / length(lane, state);
}

double PathStrip::seconds_at(Lane lane, double x, const PlayerState& state) const {
  return (x - x_ - scale_ * kLeft) / (width_ - scale_ * (kLeft + kRight)) * length(lane, state);
}

void PathStrip::press(const InputEvent& e, PlayerState& state) {
  const Lane lane = e.y < y_ + height_ / 2 ? Lane::Film : Lane::Take;
  const pipeline::CameraPath& path = state.path.path();
  held_key_.reset();
  double nearest = kGrip * scale_;
  for (std::size_t i = 0; i < path.keys.size(); ++i) {
    const double time = path.keys[i].time, at = lane == Lane::Film ? time : take_time(path, time);
    // The selected one of several that lie on one another.
    const double away = std::abs(x_of(lane, at, state) - e.x) - (state.path.selected() == i ? 0.5 : 0);
    if (away < nearest) nearest = away, held_key_ = i;
  }
  held_lane_ = lane;
  held_length_ = length(Lane::Film, state);
  state.path.begin_gesture();
  if (held_key_) return show_key(*held_key_, state);
  drag(e.x, state);
}

void PathStrip::drag(double x, PlayerState& state) const {
  const double seconds = seconds_at(*held_lane_, x, state);
  if (!held_key_) {
    if (*held_lane_ == Lane::Film) {
      state.path_time = std::clamp(seconds, 0.0, state.path.path().duration());
      state.follow_path = true;
      state.seek_by_path();
    }
    return;
  }
  if (*held_lane_ == Lane::Film) {
    state.path.move(*held_key_, seconds);
  } else if (state.time.rate() > 0) {
    pipeline::PathKey key = state.path.path().keys[*held_key_];
    const double frame = std::round(std::clamp(seconds, 0.0, take_seconds(state)) * state.time.rate());
    key.take_time = frame / state.time.rate();
    state.path.change(*held_key_, key);
  }
  show_key(*held_key_, state);
}

void PathStrip::take(std::span<const InputEvent> input, PlayerState& state) {
  for (const InputEvent& e : input) {
    switch (e.kind) {
      case InputEvent::Kind::Press:
        if (e.button == 0 && !state.path.empty() && e.x >= x_ && e.y >= y_ && e.x < x_ + width_ &&
            e.y < y_ + height_)
          press(e, state);
        break;
      case InputEvent::Kind::Move:
        if (held_lane_) drag(e.x, state);
        break;
      case InputEvent::Kind::Release:
        if (e.button != 0 || !held_lane_) break;
        drag(e.x, state);
        held_lane_.reset();
        held_length_ = 0;
        state.path.end_gesture();
        break;
      case InputEvent::Kind::Key:
        if (e.control && e.key == 'Z' && !e.shift) state.path.undo();
        if (e.control && (e.key == 'Y' || (e.key == 'Z' && e.shift))) state.path.redo();
        if (e.key == kKeyDelete && !held_lane_ && state.path.selected())
          state.path.remove(*state.path.selected());
        break;
      case InputEvent::Kind::Wheel:
        break;
    }
    if (state.path.empty()) held_lane_.reset(), state.follow_path = false;
  }
}

void PathStrip::draw(const PlayerState& state) const {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const auto point = [&](Lane lane, double seconds) {
    return ImVec2(static_cast<float>(x_of(lane, seconds, state)), static_cast<float>(y_of(lane)));
  };
  const ImVec2 corner(static_cast<float>(x_), static_cast<float>(y_)),
      far(static_cast<float>(x_ + width_), static_cast<float>(y_ + height_));
  list->PushClipRect(corner, far, true);
  list->AddRectFilled(corner, far, IM_COL32(24, 25, 28, 255), 3);
  for (const Lane lane : {Lane::Film, Lane::Take})
    list->AddLine(point(lane, 0), point(lane, length(lane, state)), IM_COL32(110, 115, 120, 255));
  const pipeline::CameraPath& path = state.path.path();
  const float r = static_cast<float>(5 * scale_);
  for (std::size_t i = 0; i < path.keys.size(); ++i) {
    const pipeline::PathKey& key = path.keys[i];
    const ImVec2 film = point(Lane::Film, key.time), take = point(Lane::Take, take_time(path, key.time));
    const bool selected = state.path.selected() == i;
    const ImU32 color = selected ? IM_COL32(255, 190, 60, 255) : IM_COL32(150, 190, 230, 255);
    list->AddLine(film, take, selected ? color : IM_COL32(150, 190, 230, 110));
    list->AddQuadFilled({film.x - r, film.y}, {film.x, film.y - r}, {film.x + r, film.y},
                        {film.x, film.y + r}, color);
    // Hollow: it follows from its neighbours.
    if (key.take_time)
      list->AddCircleFilled(take, 0.8f * r, color);
    else
      list->AddCircle(take, 0.8f * r, color);
  }
  const ImU32 now = IM_COL32(235, 90, 80, 255);
  const ImVec2 film = point(Lane::Film, state.path_time),
               take = point(Lane::Take, state.time.rate() > 0 ? state.time.frame() / state.time.rate() : 0);
  list->AddLine({film.x, corner.y}, {film.x, static_cast<float>(y_ + height_ / 2)}, now, 1.5f);
  list->AddLine({take.x, static_cast<float>(y_ + height_ / 2)}, {take.x, far.y}, now, 1.5f);
  for (const auto& [lane, name] : {std::pair{Lane::Film, "film"}, {Lane::Take, "take"}})
    list->AddText({corner.x + 4, static_cast<float>(y_of(lane)) - ImGui::GetFontSize() / 2},
                  IM_COL32(150, 150, 150, 255), name);
  list->PopClipRect();
}

}  // namespace floatstage::apps
