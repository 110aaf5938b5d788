#pragma once

#include <Eigen/Core>

#include "core/rig.h"

namespace floatstage::pipeline {

/// Which way is up for the cameras of a rig, whatever their world calls z.
struct UpAxis {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< of unit length
  /// How the cameras told: by the sides of their pictures (upright, on their side, on their head), by the
  /// plane in which they stand, or only by the mean of their upper edges.
  enum class From { Pictures, Centers, MeanUp } from = From::MeanUp;
  double roll = 0;  ///< rms angle by which pictures' sides miss the axis, radians; of From::Pictures
};

/// The axis that one side of every picture is perpendicular to: a camera that stands upright, lies on its
/// side or hangs on its head may be tilted and turned as it likes, one of its picture's sides stays level.
/// Where that leaves it open, the normal of the plane in which the cameras stand. Points to the upper edges
/// of upright pictures; where all lie on their side, to where the cameras look down from. World z when z lies
/// within `roll`.
UpAxis up_axis(const Rig& rig);

/// The circle that the cameras stand on, seen along `axis`.
struct Ring {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< at the cameras' mean height
  double radius = 0;                                 ///< metres
  double center_error = 0;  ///< standard deviation of the centre, metres; infinite where nothing tells it
};

/// Fitted to the cameras' centres across `axis` with the least sum of distances, so that a few cameras that
/// stand elsewhere (the top of a dome) do not draw it away. Fewer than four cameras, and such as stand in
/// line, have a centre_error of infinity.
Ring fit_ring(const Rig& rig, const Eigen::Vector3d& axis);

}  // namespace floatstage::pipeline
