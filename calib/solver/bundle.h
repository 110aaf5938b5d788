#pragma once

#include "calib/solver/linearize.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// Which intrinsics of the cameras whose intrinsics are not fixed are solved for.
enum class Freedom {
  None,   ///< only poses
  Focal,  ///< focal lengths and the first radial coefficient
  All,
};

struct BundleOptions {
  Loss loss = {};
  Freedom intrinsics = Freedom::All;
  bool cameras_move = true;  ///< false: cameras stay as they are, only boards and markers move
  bool offsets = false;      ///< solve for the cameras' time offsets, the reference camera's being 0
  int iterations = 50;
  int threads = 0;  ///< the result is the same for every number
};

struct BundleSummary {
  bool converged = false;
  int iterations = 0;
  double cost = 0;  ///< half the sum of squares, weak priors included
};

/// One joint least-squares solution (Ceres, Levenberg-Marquardt, Schur complement over boards and markers)
/// over all usable views. Changes the scene in place; when a step cannot be taken the scene stays as good as
/// it was.
BundleSummary solve(Scene& scene, const BundleOptions& options);

/// Which of a camera's parameters are solved for: kIntrinsics, then rotation and translation (6), then the
/// offset.
inline constexpr int kCameraParameters = kIntrinsics + 6 + 1;
using CameraMask = Eigen::Matrix<bool, kCameraParameters, 1>;
CameraMask free_parameters(const Scene& scene, int camera, const BundleOptions& options);

/// One over the sigmas of what is likely of a board's spin and velocity.
Eigen::Matrix<double, 6, 1> motion_weights(const SceneBoard& board);

/// Sigmas of the weak priors that keep a poor capture solvable: far wider than any useful capture's own
/// knowledge.
Intrinsics prior_sigmas(const SceneCamera& camera);

/// Sigma of how far a plain lens' pixels are from the shape (fx / fy) that they began with: sensors' pixels
/// are squares, and a turntable's pictures alone would let the scene be stretched along its axis.
inline constexpr double kPixelShapeSigma = 1e-3;

}  // namespace floatstage::calib::solver
