// Method:  Newton's method on the sparsity of matting components
// Paper:   A. Levin, A. Rav-Acha, D. Lischinski, "Spectral matting", PAMI 2008, eq. 14 and 15
// Differs: on a part of the pixels; each power is replaced by
//          the parabola that touches it
// ADR:     none; docs/algorithms/spectral-matting.md

#include "matting/spectral/sparse_components.h"

#include <algorithm>
#include <vector>

#include <Eigen/Cholesky>

#include "matting/blas.h"

namespace floatstage::matting {
namespace {

constexpr Eigen::Index kTile = 512;  // pixels a Gram update: their weighted copy stays in the cache
constexpr float kNearlyThere =
    1e-3f;  // of opacity: nearer to 0 or 1 counts as this near, a quarter of an 8-bit step
constexpr double kSettled = 1e-3;  // mean change of opacity that ends the iteration

using Eigen::ArrayXXf;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;

// |distance|^(gamma - 2): how strongly the touching parabola pulls.
ArrayXXf pull(const ArrayXXf& distance, double gamma) {
  return (distance.abs().max(kNearlyThere).log() * static_cast<float>(gamma - 2)).exp();
}

}  // namespace

MatrixXd sparse_components(const MatrixXf& samples, const MatrixXd& start, const VectorXd& ones,
                           const SparsityOptions& options) {
  const Index dimensions = samples.rows(), count = samples.cols(), k = start.cols();
  MatrixXd y = start;
  MatrixXf alpha(k, count), before;
  MatrixXf weighted(dimensions, kTile), gram(dimensions, dimensions);
  ArrayXXf to_one, to_both;
  std::vector<Eigen::LDLT<MatrixXd>> factors(static_cast<std::size_t>(k));
  for (int step = 0; step < options.steps; ++step) {
    before = alpha;
    transposed_product(y.cast<float>(), samples, alpha);
    if (step > 0 && (alpha - before).cwiseAbs().cast<double>().mean() < kSettled) break;

    std::vector<MatrixXd> quadratic(static_cast<std::size_t>(k), MatrixXd::Zero(dimensions, dimensions));
    MatrixXd linear = MatrixXd::Zero(dimensions, k);
    for (Index first = 0; first < count; first += kTile) {
      const Index n = std::min(kTile, count - first);
      const auto tile = samples.middleCols(first, n);
      const ArrayXXf values = alpha.middleCols(first, n).array();
      to_one = pull(1 - values, options.gamma);
      to_both = (to_one + pull(values, options.gamma)).sqrt();
      linear += (tile * to_one.matrix().transpose()).cast<double>();
      for (Index c = 0; c < k; ++c) {
        weighted.leftCols(n).noalias() = tile * to_both.row(c).matrix().asDiagonal();
        gram.setZero();
        add_outer(weighted.leftCols(n), gram);
        quadratic[static_cast<std::size_t>(c)] += gram.cast<double>();
      }
    }
    // Lagrange: A_c y_c = b_c - m with the m that makes the y_c sum to `ones`.
    MatrixXd inverse_sum = MatrixXd::Zero(dimensions, dimensions);
    VectorXd free_sum = VectorXd::Zero(dimensions);
    for (Index c = 0; c < k; ++c) {
      MatrixXd full = quadratic[static_cast<std::size_t>(c)].selfadjointView<Eigen::Lower>();
      full.diagonal().array() += 1e-9 * full.diagonal().maxCoeff();
      auto& factor = factors[static_cast<std::size_t>(c)];
      factor.compute(full);
      inverse_sum += factor.solve(MatrixXd::Identity(dimensions, dimensions));
      y.col(c) = factor.solve(linear.col(c));
      free_sum += y.col(c);
    }
    const VectorXd multiplier = inverse_sum.ldlt().solve(free_sum - ones);
    for (Index c = 0; c < k; ++c) y.col(c) -= factors[static_cast<std::size_t>(c)].solve(multiplier);
  }
  return y;
}

}  // namespace floatstage::matting
