#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "core/rig.h"

namespace floatstage::pipeline {

/// Where an exported page begins: before the first camera, as high as the cameras stand, the subject whole.
/// One turns around `target` about `up`, whatever the world calls z.
struct PageStart {
  Eigen::Vector3d target, up;
  Eigen::Vector3d east;  ///< level, towards the first camera: where azimuth and elevation are 0
  double elevation = 0;  ///< radians
  double distance = 0;   ///< metres
  double fov_y = 0;      ///< degrees

  Eigen::Vector3d eye() const {
    return target + distance * (std::cos(elevation) * east + std::sin(elevation) * up);
  }
};
PageStart page_start(const Rig& rig, const Eigen::AlignedBox3d& subject);

}  // namespace floatstage::pipeline
