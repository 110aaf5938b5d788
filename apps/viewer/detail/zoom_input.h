#pragma once

#include <span>
#include <string>

#include "apps/viewer/mattes/picture_fit.h"
#include "apps/viewer/window/input_event.h"

namespace floatstage::apps {

/// Everything that hands can change in the zoom window.
struct ZoomState {
  PictureFit fit;           ///< of the root in the stage
  bool split = false;       ///< the root alone at the right, enlarged as any texture
  double split_at = 0.5;    ///< share of the stage
  bool provenance = false;  ///< colours say where pixels come from
  bool graph = false;       ///< photographs are outlined and named
  std::string status = {};  ///< one line at the bottom

  int held = -1;             ///< button of a drag; -1: none
  bool moves_split = false;  ///< what that drag does
  double last_x = 0, last_y = 0;
  double stage_x = 0, stage_width = 1;  ///< where the stage lies in the window, px
};

/// What hands asked for beside.
struct ZoomRequests {
  bool screenshot = false;
};

/// The wheel zooms to the pixel under the cursor, a drag pans, with Control it moves the split; X splits, P
/// shows provenance, G the graph, H the whole, = and - zoom to the middle, F12 keeps a screenshot. A drag
/// belongs to the stage when it began there. Without a window.
ZoomRequests take_zoom_input(std::span<const InputEvent> input, ZoomState& state);

}  // namespace floatstage::apps
