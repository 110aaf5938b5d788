#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/calibrate.h"
#include "core/measured.h"

namespace floatstage::calib {

/// Where a calibration must hold: points all over it, and how it was chosen, for the report.
struct WorkingVolume {
  std::vector<Eigen::Vector3d> points;                                            ///< metres, world
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();  ///< of the box around them
  std::string how;  ///< "the convex hull of all targets, 1.2 x 0.8 x 0.9 m"
};

/// A box of the world.
WorkingVolume box_volume(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// The convex hull of every target's points that took part (to the planes of some hundred directions). Empty
/// when there are none.
WorkingVolume hull_of_targets(const Calibration& calibration);

/// RMS of sigma_px over what a camera sees of the volume. For one volume it never rises when views are added
/// and their noise is that of the others.
Measured projection_sigma(const Calibration& calibration, const ProjectionUncertainty& uncertainty,
                          int camera, const WorkingVolume& volume);

/// What a small step d of all cameras' parameters (as Calibration::covariance's rows) counts over the volume:
/// dᵀ metric d is the sum over cameras of its mean square in pixels, each in units of that camera's own
/// projection_sigma(). Common motions count nothing.
Eigen::MatrixXd projection_metric(const Calibration& calibration, const WorkingVolume& volume);

}  // namespace floatstage::calib
