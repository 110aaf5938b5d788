#pragma once

#include <Eigen/Core>

#include "calib/solver/bundle.h"

namespace floatstage::calib::solver {

/// Covariance of all cameras' parameters at a solution, kCameraParameters rows a camera, zero for what was
/// not solved for: the inverse of the Schur complement of boards and markers, weak priors included. Positive
/// semidefinite.
Eigen::MatrixXd camera_covariance(const Scene& scene, const BundleOptions& options);

/// Numbers measured and numbers solved for: what the sum of squares is expected to be.
struct Redundancy {
  double rows = 0, unknowns = 0;
  double share() const { return rows > unknowns ? (rows - unknowns) / rows : 0; }
};
Redundancy redundancy(const Scene& scene, const BundleOptions& options);

}  // namespace floatstage::calib::solver
