#pragma once

namespace floatstage::studio {

/// Milliseconds on the wall, from a set's delivery to its scene.
struct SceneTimes {
  double wait = 0;   ///< from the first picture's production until work began
  double nodes = 0;  ///< keys, outlines and tiles of all cameras
  double hull = 0;
  double key = 0, outline = 0, tile = 0;  ///< the nodes' work, summed over the cameras
};

}  // namespace floatstage::studio
