#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/result.h"
#include "core/rig.h"

namespace floatstage::render {

/// Cameras of a light field: on a plane, in rows and columns (Levoy and Hanrahan 1996), each place taken
/// once. Rows and columns need not be evenly spaced, and the cameras may be turned.
struct CameraGrid {
  int rows = 0, columns = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< world, on the plane
  Eigen::Vector3d right = Eigen::Vector3d::UnitX(),  ///< along rows, as the cameras see right; of length 1
      down = Eigen::Vector3d::UnitY();               ///< along columns
  std::vector<double> x, y;                          ///< metres from the origin: of each column, of each row
  std::vector<int> cameras;                          ///< row after row: indices into what was given

  Eigen::Vector3d normal() const { return right.cross(down); }  ///< where the cameras look
};

/// The grid on which these cameras stand, to a quarter of the distance between neighbours. InvalidArgument
/// with a sentence when they stand on none: fewer than four, not in a plane, a single row or column, holes.
Result<CameraGrid> camera_grid(const std::vector<RigCamera>& cameras);

}  // namespace floatstage::render
