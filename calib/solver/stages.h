#pragma once

#include <vector>

#include "calib/calibrate.h"
#include "calib/solver/bundle.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// From a start to a solution: first loosely with few intrinsics, then all of them, leaving outliers out and
/// taking them back until the set stays as it is. Measures the cameras' noise on the way. Returns the options
/// that the last step used.
BundleOptions solve_in_stages(Scene& scene, const CalibrationOptions& options);

/// The last stages only, from a solution to which frames were added.
BundleOptions solve_again(Scene& scene, const CalibrationOptions& options);

/// Keeps a point when it is nearer than `sigmas` of its camera's noise; returns how many changed.
int select_inliers(Scene& scene, double sigmas);

/// Sets each camera's noise from its kept points.
void measure_noise(Scene& scene, const BundleOptions& options);

}  // namespace floatstage::calib::solver
