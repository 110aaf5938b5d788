#pragma once

#include <memory>
#include <vector>

#include "apps/studio/camera_view.h"
#include "apps/studio/studio_scene.h"

namespace floatstage {

/// Milliseconds on the wall, from a set's delivery to its scene.
struct SceneTimes {
  double wait = 0;   ///< from the first picture's production until work began
  double nodes = 0;  ///< keys, outlines and tiles of all cameras
  double hull = 0;
  double key = 0, outline = 0, tile = 0;  ///< the nodes' work, summed over the cameras
};

/// A surface and the textures that belong to it: what a view is drawn from. Immutable once published.
struct LiveScene {
  StudioScene scene;
  std::vector<std::shared_ptr<const CameraView>>
      views;  ///< in the rig's order; null: the camera missed the instant
  SceneTimes times;
  Timestamp ready;  ///< when it was complete
};

}  // namespace floatstage
