#pragma once

#include <vector>

#include "calib/calibrate.h"
#include "calib/solver/bundle.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// Every point of every usable view with its error and depth.
std::vector<PointError> point_errors(const Scene& scene, const Observations& observations);

/// What the errors say of each camera, and the sigmas of its parameters; covariance as camera_covariance()
/// gives it.
std::vector<CameraQuality> camera_qualities(const Scene& scene, const std::vector<PointError>& errors,
                                            const Eigen::MatrixXd& covariance);

/// RMS of the kept points' errors of one camera, in px.
Measured rms_of(const std::vector<PointError>& errors, int camera);

/// The known lengths as the cameras alone measure them.
std::vector<LengthQuality> measure_lengths(const Scene& scene);
LengthQuality merged(const std::vector<LengthQuality>& lengths);

}  // namespace floatstage::calib::solver
