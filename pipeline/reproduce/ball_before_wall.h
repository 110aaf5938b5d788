#pragma once

#include "core/image.h"
#include "core/rig.h"
#include "pipeline/reproduce/comparison.h"

namespace floatstage::pipeline {

struct BallOptions {
  int width = 480, height = 360;  ///< px
  int views = 3;                  ///< between the cameras
  double gain = 0.06;             ///< cameras are brighter and darker by so much, as if never calibrated
  double off = 1.5;               ///< px by which each camera's calibration points aside
};

/// A scene of occlusions (thesis §11.3): a painted ball before a painted wall, three cameras of which each
/// sees other parts of the wall, and a proxy whose ball is coarse and too large and whose wall stands 2 cm
/// behind.
TestScene ball_before_wall(const BallOptions& options);

/// Where not all cameras of the scene see what `view` shows, and 8 px about: 255, elsewhere 0.
Image about_occlusions(const TestScene& scene, const RigCamera& view);

}  // namespace floatstage::pipeline
