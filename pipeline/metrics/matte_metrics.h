#pragma once

#include "core/image.h"

namespace floatstage::pipeline {

// How near a matte is to the true one. Opacity enters as 0…1, "subject" means >= 128 of 255. docs/metrics.md
// says what each one sees.
//
// All functions: both pictures have one channel and one size (anything else is our bug and throws
// CheckFailure). Pure, thread safe, same result on any thread.

/// Sum of absolute differences, in pixels: 1 is one pixel wrong altogether.
double matte_sad(const Image& matte, const Image& truth);
double matte_mad(const Image& matte, const Image& truth);  ///< mean absolute difference
double matte_mse(const Image& matte, const Image& truth);  ///< mean squared difference

/// Rhemann et al. 2009, eq. 3: summed squared difference of the gradient magnitudes under derivatives of a
/// Gaussian of sigma 1.4 px, kernels of unit norm.
double matte_gradient_error(const Image& matte, const Image& truth);

/// Rhemann et al. 2009, eq. 4-5: summed difference of how well each pixel hangs together with the largest
/// component that is opaque in both, by thresholds a tenth apart and 4-neighbours; steps under 0.15 are
/// forgiven.
double matte_connectivity_error(const Image& matte, const Image& truth);

/// Intersection over union of the subjects; 1 when both are empty.
double matte_iou(const Image& matte, const Image& truth);

/// F-measure of the subjects' boundary pixels, of which one is found when the other boundary passes within 1
/// px of it. 1 when neither has a boundary, 0 when one has none.
double matte_boundary_f(const Image& matte, const Image& truth);

/// Flicker that the truth does not have (Erofeev et al. 2015): root mean square of the difference between the
/// matte's change from one frame to the next and the truth's.
double matte_dtssd(const Image& before, const Image& now, const Image& truth_before, const Image& truth_now);

struct MatteScores {
  double sad = 0, mad = 0, mse = 0, gradient = 0, connectivity = 0, iou = 0, boundary_f = 0;
};

MatteScores score_matte(const Image& matte, const Image& truth);

}  // namespace floatstage::pipeline
