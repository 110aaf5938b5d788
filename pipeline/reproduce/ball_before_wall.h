#pragma once

#include "core/image.h"
#include "core/rig.h"
#include "pipeline/reproduce/comparison.h"

namespace floatstage::pipeline {

struct BallOptions {
  int width = 480, height = 360;  ///< px
  int views = 3;                  ///< in the middle between two cameras; 3 at most
  double gain = 0.1;              ///< cameras are brighter and darker by so much, as if never calibrated
  double off = 1.5;               ///< px by which each camera's calibration points aside
};

/// A scene of occlusions (thesis §11.3): a painted ball before a painted wall, four cameras of which each
/// sees other parts of the wall, and a proxy whose ball is coarse and too large and whose wall stands 2 cm
/// behind.
TestScene ball_before_wall(const BallOptions& options);

/// The parts of the wall that not all cameras of the scene see, and 8 px about, but for the ball and its
/// outline: 255, elsewhere 0.
Image about_occlusions(const TestScene& scene, const RigCamera& view);

}  // namespace floatstage::pipeline
