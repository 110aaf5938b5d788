#include "apps/viewer/play/stage_input.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace floatstage::apps {
namespace {

constexpr int kLeft = 0, kRight = 1, kMiddle = 2;
constexpr double kTurn = 3;     // radians for a drag over the picture's height
constexpr double kNotch = 1.1;  // of the wheel

}  // namespace

void StageInput::set_area(double x, double y, double width, double height) {
  x_ = x, y_ = y;
  width_ = std::max(1.0, width), height_ = std::max(1.0, height);
}

bool StageInput::holds(double x, double y) const {
  return x >= x_ && y >= y_ && x < x_ + width_ && y < y_ + height_;
}

void StageInput::drag(double dx, double dy, PlayerState& state) const {
  const double across = dx / height_, down = dy / height_;
  if (button_ == kLeft && control_ && state.split)
    state.split_at = std::clamp(state.split_at + static_cast<float>(dx / width_), 0.02f, 0.98f);
  else if (button_ == kMiddle || (button_ == kLeft && shift_))
    state.camera.pan(-across, down);
  else if (button_ == kLeft)
    state.camera.orbit(-across * kTurn, down * kTurn);
  else if (button_ == kRight)
    state.camera.look(across * kTurn, -down * kTurn);
}

void StageInput::take(std::span<const InputEvent> input, bool free, PlayerState& state) {
  if (!free) button_ = -1;
  for (const InputEvent& e : input) {
    switch (e.kind) {
      case InputEvent::Kind::Press:
        if (!free || button_ >= 0 || !holds(e.x, e.y)) break;
        button_ = e.button;
        control_ = e.control, shift_ = e.shift;
        last_x_ = e.x, last_y_ = e.y;
        break;
      case InputEvent::Kind::Move:
      case InputEvent::Kind::Release:
        if (button_ >= 0) drag(e.x - last_x_, e.y - last_y_, state);
        last_x_ = e.x, last_y_ = e.y;
        if (e.kind == InputEvent::Kind::Release && e.button == button_) button_ = -1;
        break;
      case InputEvent::Kind::Wheel:
        if (free && holds(e.x, e.y)) state.camera.zoom(std::pow(kNotch, e.wheel));
        break;
      case InputEvent::Kind::Key:
        break;
    }
  }
}

void PlayerState::toggle_split() {
  split = !split;
  if (!split) {
    left = alone;
    return;
  }
  alone = left;
  const auto place = [&](const char* name) { return std::find(methods.begin(), methods.end(), name); };
  if (left != right || place("linear") == methods.end() || place("floating") == methods.end()) return;
  left = static_cast<int>(place("linear") - methods.begin());
  right = static_cast<int>(place("floating") - methods.begin());
}

void PlayerState::add_key() {
  pipeline::PathKey key = camera.key();
  key.take_time.reset();
  if (keys_hold_take && time.rate() > 0) key.take_time = time.frame() / time.rate();
  path.select(path.append(key));
  path_time = path.path().duration();
}

void PlayerState::seek_by_path() {
  std::vector<int> frames(static_cast<std::size_t>(time.frames()));
  std::iota(frames.begin(), frames.end(), 0);
  time.seek(static_cast<int>(pipeline::shown_at(path.path(), path_time, time.rate(), frames)));
}

void take_shortcuts(std::span<const InputEvent> input, const pipeline::PathKey& home, PlayerState& state) {
  for (const InputEvent& e : input) {
    if (e.kind != InputEvent::Kind::Key || e.control) continue;
    const int method = e.key - '1';
    if (method >= 0 && method < std::min(9, static_cast<int>(state.methods.size()))) state.left = method;
    if (e.key == kKeyLeft) state.time.step(-1);
    if (e.key == kKeyRight) state.time.step(1);
    if (e.repeated) continue;
    if (e.key == ' ') state.time.playing = !state.time.playing;
    if (e.key == 'K') state.add_key();
    if (e.key == 'C') state.show_cameras = !state.show_cameras;
    if (e.key == 'X') state.toggle_split();
    if (e.key == 'V') state.muted = !state.muted;
    if (e.key == kKeyF3) state.show_times = !state.show_times;
    if (e.key == 'H') state.camera.set(home);
  }
}

}  // namespace floatstage::apps
