#pragma once

#include <span>

#include "apps/viewer/play/player_state.h"
#include "apps/viewer/window/input_event.h"

namespace floatstage::apps {

/// What hands do on the player's stage, event by event: a drag that begins and ends between two pictures
/// moves the camera as far as a slow one. Without a window.
class StageInput {
 public:
  /// Where the stage lies in the window, px.
  void set_area(double x, double y, double width, double height);
  /// Moves the camera, or with Control the line between left and right. A drag belongs to the stage when it
  /// began there. What was held when `free` is false (the camera rides its path) is let go.
  void take(std::span<const InputEvent> input, bool free, PlayerState& state);

 private:
  bool holds(double x, double y) const;
  void drag(double dx, double dy, PlayerState& state) const;

  double x_ = 0, y_ = 0, width_ = 1, height_ = 1;
  int button_ = -1;  ///< that is held; -1: none
  bool control_ = false, shift_ = false;
  double last_x_ = 0, last_y_ = 0;
};

/// Keys that work anywhere: space plays, arrows step, K sets a path key, C shows the cameras, X splits, V
/// mutes, F3 shows times, H goes to `home`, 1…9 choose the method.
void take_shortcuts(std::span<const InputEvent> input, const pipeline::PathKey& home, PlayerState& state);

}  // namespace floatstage::apps
