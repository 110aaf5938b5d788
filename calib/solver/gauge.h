#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/observations.h"
#include "calib/solver/scene.h"
#include "core/result.h"

namespace floatstage::calib::solver {

/// Moves the solved scene into the world that was asked for, covariance (kCameraParameters rows a camera)
/// with it. BadData when the floor board was not solved for.
Result<void> set_gauge(Scene& scene, const Observations& observations, Eigen::MatrixXd& covariance,
                       std::vector<std::string>& remarks);

}  // namespace floatstage::calib::solver
