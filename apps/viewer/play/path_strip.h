#pragma once

#include <optional>
#include <span>

#include "apps/viewer/play/player_state.h"
#include "apps/viewer/window/input_event.h"

namespace floatstage::apps {

/// The path's time line: two lanes, the film's time above and the take's below. A key has a handle in each,
/// joined by a line: parallel lines are real time, lines that meet at one frame below a freeze. Handles are
/// dragged; elsewhere the upper lane moves the film's time. Arithmetic, without a window, but for draw().
class PathStrip {
 public:
  /// Where it lies in the window, px; `scale` is the ui_scale() that handles are drawn with.
  void set_area(double x, double y, double width, double height, double scale = 1);
  /// Presses and drags that began here, and the keys Delete, Control Z and Control Y (or Shift Control Z).
  void take(std::span<const InputEvent> input, PlayerState& state);
  /// Into the present ImGui window, and there only.
  void draw(const PlayerState& state) const;

  static constexpr float kHeight = 52;  ///< px before ui_scale()

 private:
  enum class Lane { Film, Take };
  double x_of(Lane lane, double seconds, const PlayerState& state) const;
  double seconds_at(Lane lane, double x, const PlayerState& state) const;
  double y_of(Lane lane) const { return y_ + height_ * (lane == Lane::Film ? 0.25 : 0.75); }
  double length(Lane lane, const PlayerState& state) const;
  void press(const InputEvent& e, PlayerState& state);
  void drag(double x, PlayerState& state) const;

  double x_ = 0, y_ = 0, width_ = 1, height_ = 1, scale_ = 1;
  std::optional<Lane> held_lane_ = {};        // what a drag moves; without a key the film's time
  std::optional<std::size_t> held_key_ = {};  // of the drag
  double held_length_ = 0;                    // of the film's lane while a drag would change it
};

/// Key frame `index` is shown: the camera stands there, and the take shows what it does.
void show_key(std::size_t index, PlayerState& state);

}  // namespace floatstage::apps
