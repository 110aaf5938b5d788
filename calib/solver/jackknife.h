#pragma once

#include <Eigen/Core>

#include "calib/solver/bundle.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// The covariance of the cameras' parameters as the capture itself shows it: how far blocks of
/// successive frames pull the solution each to its side. Rows as camera_covariance(). Errors that a
/// whole board has in common (its shape, its motion) show here and not there. `blocks` comes back as how many
/// there were; below kFewestBlocks the result is empty: so few say nothing.
inline constexpr int kFewestBlocks = 3;
Eigen::MatrixXd jackknife_covariance(const Scene& scene, const BundleOptions& options, int& blocks);

}  // namespace floatstage::calib::solver
