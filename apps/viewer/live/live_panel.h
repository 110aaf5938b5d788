#pragma once

#include <string>

#include "apps/viewer/live/control_model.h"

namespace floatstage::apps {

/// What the live window shows beside the player's panels.
struct LivePanelState {
  double fps = 0, latency_ms = 0;  ///< over the last second
  std::size_t quality = 0;         ///< of live_qualities(): the operator's choice is written here
  bool automatic = true;           ///< the quality follows the rate
  bool hold = false;               ///< the present scene is kept
  std::string remark = {};         ///< what is wrong with the scene; empty when nothing is
  unsigned doubts = 0;             ///< a texture of the cameras that it names; 0: none
  float doubts_shape = 1;          ///< its height over its width
  std::string stream = {};         ///< where pictures go and whether somebody receives them; empty: none
  std::string label = "take";      ///< of the next recording
};

/// Rate, latency, quality, the cameras' health and the record button, which goes to the model at once. Draws
/// into the present ImGui window.
void draw_live_panel(LivePanelState& state, ControlModel& model);

}  // namespace floatstage::apps
