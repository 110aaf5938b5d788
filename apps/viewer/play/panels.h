#pragma once

#include "apps/viewer/play/path_strip.h"

namespace floatstage::apps {

/// What the operator pressed in the panels and the player must do.
struct PanelRequests {
  bool save_path = false, load_path = false, render_film = false, quit = false, home = false;
  bool who = false;  ///< others are to be seen
};

/// The controls at the left: method and comparison, intermediates, cameras, camera path. Draws into the
/// present ImGui window.
PanelRequests draw_controls(PlayerState& state, double render_milliseconds, int film_pictures);

/// Does what was asked for the camera and its path; what came of it is the state's status.
void apply_camera_requests(const PanelRequests& requests, const pipeline::PathKey& home, PlayerState& state);

/// The time line at the bottom: play, step, speed, frame slider, the path's own where there is one, and the
/// last message.
void draw_time_line(PlayerState& state, PathStrip& strip);

}  // namespace floatstage::apps
