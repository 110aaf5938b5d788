#pragma once

#include "calib/solver/bundle.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// Cameras without a common trigger: when their pictures were taken, and how boards moved then.

/// Puts each board view to the frame whose instant is nearest to the view's own, now that offsets are known:
/// a camera that is three quarters of a frame late shows the frame before. Returns how many views changed.
int regroup(Scene& scene);

/// Sets each board view's jitter to what is likeliest with everything else as it is.
void estimate_jitter(Scene& scene);

/// Estimates how far pictures stray from their instants (jitter_sigma, and each board view's own jitter) and
/// how far hands stray from the motion that neighbouring frames suggest (spin_doubt, velocity_doubt), as
/// variance components of the present solution.
void measure_timing(Scene& scene);

}  // namespace floatstage::calib::solver
