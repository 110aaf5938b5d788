#pragma once

#include <memory>
#include <vector>

#include "studio/messages/camera_view.h"
#include "studio/messages/scene_times.h"
#include "studio/messages/studio_scene.h"

namespace floatstage::studio {

/// A surface and the textures that belong to it: what a view is drawn from. Immutable once published.
struct LiveScene {
  StudioScene scene;
  std::vector<std::shared_ptr<const CameraView>>
      views;  ///< in the rig's order; null: the camera missed the instant
  SceneTimes times;
  Timestamp ready;  ///< when it was complete
};

}  // namespace floatstage::studio
