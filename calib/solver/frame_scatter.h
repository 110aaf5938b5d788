#pragma once

#include <Eigen/Core>

#include "calib/solver/bundle.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// How far a capture's own frames contradict one another, over what their points' noise explains.
struct FrameScatter {
  int blocks = 0;      ///< runs of successive frames whose errors are taken as independent
  double factor2 = 0;  ///< squared errors over what noise explains: 1 where noise is all there is
  double freedom = 0;  ///< degrees of freedom of that estimate

  /// The half-width of the interval that holds the truth as often as one sigma of a normal error does, over
  /// the noise's sigma: a factor from few blocks may be too small by chance, and is enlarged for it (the
  /// quantile of Student's t).
  double sigma_factor() const;
};
inline constexpr int kFewestBlocks = 3;

/// Runs of successive frames pull the solution each to its side; errors that a whole board has in common (its
/// shape, its motion) show here and not in the points' noise. Runs become longer as long as neighbouring ones
/// pull alike. `metric`: square, kCameraParameters rows a camera: what a step of the cameras' parameters
/// counts. `blocks` is 0 where there are fewer than kFewestBlocks frames or nothing is solved for.
FrameScatter frame_scatter(const Scene& scene, const BundleOptions& options, const Eigen::MatrixXd& metric);

}  // namespace floatstage::calib::solver
