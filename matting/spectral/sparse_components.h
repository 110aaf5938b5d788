#pragma once

#include <Eigen/Core>

// Private to the stage.
namespace floatstage::matting {

struct SparsityOptions {
  double gamma = 0.9;
  int steps = 20;
};

/// Newton's method on sum_k sum_p |alpha_pk|^gamma + |1 - alpha_pk|^gamma with alpha = samples' Y and
/// sum_k Y_k = ones ("Spectral Matting", eq. 14 and 15): every step replaces each power by the parabola that
/// touches it and solves for all components at once.
///
/// `samples`: eigenvectors x pixels, the pixels that count. `start`: eigenvectors x K. `ones`: the
/// coefficients of the picture that is 1 everywhere. Returns Y, eigenvectors x K.
Eigen::MatrixXd sparse_components(const Eigen::MatrixXf& samples, const Eigen::MatrixXd& start,
                                  const Eigen::VectorXd& ones, const SparsityOptions& options);

}  // namespace floatstage::matting
