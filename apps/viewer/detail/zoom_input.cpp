#include "apps/viewer/detail/zoom_input.h"

#include <algorithm>
#include <cmath>

namespace floatstage::apps {
namespace {

constexpr double kNotch = 1.15;  // of the wheel
constexpr double kKey = 1.25;    // of a key

void drag(double dx, double dy, ZoomState& state) {
  if (state.moves_split)
    state.split_at = std::clamp(state.split_at + dx / state.stage_width, 0.02, 0.98);
  else
    state.fit.pan(dx, dy);
}

void zoom_to_middle(double factor, ZoomState& state) {
  const Eigen::Vector2d middle = state.fit.to_window(state.fit.middle());
  state.fit.zoom(middle.x(), middle.y(), factor);
}

void press_key(const InputEvent& e, ZoomState& state, ZoomRequests& requests) {
  if (e.key == '=') zoom_to_middle(kKey, state);
  if (e.key == '-') zoom_to_middle(1 / kKey, state);
  if (e.repeated || e.control) return;
  if (e.key == 'X') state.split = !state.split;
  if (e.key == 'P') state.provenance = !state.provenance;
  if (e.key == 'G') state.graph = !state.graph;
  if (e.key == 'H') state.fit.whole();
  if (e.key == kKeyF12) requests.screenshot = true;
}

}  // namespace

ZoomRequests take_zoom_input(std::span<const InputEvent> input, ZoomState& state) {
  ZoomRequests requests;
  for (const InputEvent& e : input) {
    switch (e.kind) {
      case InputEvent::Kind::Press:
        if (state.held >= 0 || !state.fit.holds(e.x, e.y)) break;
        state.held = e.button;
        state.moves_split = e.control && state.split;
        state.last_x = e.x, state.last_y = e.y;
        break;
      case InputEvent::Kind::Move:
      case InputEvent::Kind::Release:
        if (state.held >= 0) drag(e.x - state.last_x, e.y - state.last_y, state);
        state.last_x = e.x, state.last_y = e.y;
        if (e.kind == InputEvent::Kind::Release && e.button == state.held) state.held = -1;
        break;
      case InputEvent::Kind::Wheel:
        if (state.fit.holds(e.x, e.y)) state.fit.zoom(e.x, e.y, std::pow(kNotch, e.wheel));
        break;
      case InputEvent::Kind::Key:
        press_key(e, state, requests);
        break;
    }
  }
  return requests;
}

}  // namespace floatstage::apps
