#pragma once

#include <vector>

#include "core/camera.h"
#include "core/frame.h"
#include "core/matte.h"
#include "core/mesh.h"

namespace floatstage {

/// A virtual camera is a camera. Its lens must be a pinhole.
struct View {
  CameraModel model;
  Rigid3 view_from_world;
  double near_plane = 0.01, far_plane = 100;  ///< metres along the view's z axis
};

/// Everything the renderer needs of one instant. Immutable once published.
struct SceneFrame {
  FrameSet images;
  std::vector<Matte> mattes;  ///< mattes[i] belongs to rig.cameras[i]; may be empty
  Mesh mesh;
};

}  // namespace floatstage
