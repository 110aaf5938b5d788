#pragma once

#include <vector>

#include <Eigen/Core>

#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// How errors count: squared, or less and less the larger they are (Cauchy). In units of their sigma.
struct Loss {
  double cauchy = 0;  ///< 0: squared
};

/// Rows of a board view after compression: one more than what it can tell (13 intrinsics, 6 of the pose).
inline constexpr int kBoardRows = kIntrinsics + 6 + 1;

/// One view, linear in everything that it depends on. Changes of a pose are a rotation vector (rad)
/// multiplied on the left and an addition to the translation (m).
struct LinearView {
  bool valid = false;  ///< false: a kept point is behind the camera
  Eigen::VectorXd residual;
  Eigen::Matrix<double, Eigen::Dynamic, kIntrinsics> by_intrinsics;
  Eigen::Matrix<double, Eigen::Dynamic, 6> by_camera;
  Eigen::MatrixXd
      by_object;  ///< 6 columns for a board, 12 when its spin and velocity are solved for too, 3 a marker
  Eigen::VectorXd by_offset;  ///< per second
  /// What the view says of its own jitter (s), which is eliminated from all of the above.
  double jitter = 0, jitter_sigma = 0;
};

/// The kept points of a usable view. A board's view depends on its 2n pixel coordinates only through 19
/// numbers, so its rows are replaced by the triangle of their QR decomposition: same sums of squares, same
/// normal equations, 20 rows.
void linearize(const Scene& scene, const SceneView& view, Loss loss, bool with_derivatives, LinearView& out);

/// (distance - known) / sigma of two cameras' centres, and its derivative by a's and then b's pose (6 each,
/// as above).
struct LinearDistance {
  double residual = 0;
  Eigen::Matrix<double, 1, 12> by_poses = Eigen::Matrix<double, 1, 12>::Zero();
};
LinearDistance linearize_distance(const SceneDistance& known, const Rigid3& a_from_world,
                                  const Rigid3& b_from_world);

/// What is known of markers beside their views, in units of its sigma: a row for each length between two of
/// them, three for each surveyed position. `by_positions` (3 columns a marker) may be null.
Eigen::VectorXd marker_residual(const SceneMarkers& markers, const Target& target,
                                Eigen::MatrixXd* by_positions);

}  // namespace floatstage::calib::solver
