// Method:  the smallest eigenpairs of the matting Laplacian by shift-invert
// Paper:   block Krylov and inverse iteration with Rayleigh-Ritz, for "Spectral matting" (Levin and others,
//          2008)
// Differs: warm from the frame before; one factor does for all steps
// ADR:     0091

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "core/random.h"
#include "core/text.h"
#include "matting/blas.h"
#include "matting/spectral/grid_factor.h"
#include "matting/spectral/spectral_matting.h"

namespace floatstage::matting {
namespace {

constexpr double kShift = 1e-7;  // below the second eigenvalue of any photograph, far above rounding
constexpr int kSpare = 10;  // pairs kept beyond those asked for: the next frame's iteration starts from them

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Makes the columns of `block` orthonormal from their Gram matrix (Stathopoulos, Wu 2002): block = new block
// * R. Directions that are only rounding come out as noise; the caller's second pass makes that orthogonal
// too.
MatrixXd orthonormalize(Eigen::Ref<MatrixXd> block, MatrixXd& scratch) {
  const Index b = block.cols();
  MatrixXd gram(b, b);
  transposed_product(block, block, gram);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(gram);
  const double top = std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
  const VectorXd root = eigen.eigenvalues().cwiseMax(1e-15 * top).cwiseSqrt();
  scratch = block;
  product(scratch, eigen.eigenvectors() * root.cwiseInverse().asDiagonal(), block);
  return root.asDiagonal() * eigen.eigenvectors().transpose();
}

bool one_colour(const Image& picture) {
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    if (picture.pixels[i] != picture.pixels[i % picture.channels]) return false;
  return true;
}

// Ritz pairs in elimination order: (L + shift) v = value v + residual.
struct Ritz {
  VectorXd values;
  double residual = 0;
};

}  // namespace

struct EigenSolver::Impl {
  int width = 0, height = 0;
  SpectralOptions options;
  GridFactor factor;
  LaplacianStencil stencil;
  MatrixXd basis;           // the Krylov space, or the previous vectors
  MatrixXd block, scratch;  // one step
  MatrixXd ritz_vectors;

  explicit Impl(GridFactor f) : factor(std::move(f)) {}

  Index size() const { return static_cast<Index>(width) * height; }
  int wanted() const { return options.eigenvectors + kSpare; }

  struct Combination {
    Ritz ritz;
    MatrixXd weights;  // of the basis' columns
  };
  Combination combine(const MatrixXd& projected, const MatrixXd& last) const;
  Result<Ritz> cold();
  Result<Ritz> warm(const EigenPairs& previous);
  EigenPairs to_pixels(const Ritz& ritz) const;
};

// The pairs wanted, from the projection of the inverse on the Krylov space and what the last step left beyond
// it. The Ritz vector Q s of value theta is replaced by (L + shift)^-1 Q s / theta, which the last step has
// computed already: one more inverse iteration for nothing, and its residual is |B s_last| / theta^2 without
// forming it.
EigenSolver::Impl::Combination EigenSolver::Impl::combine(const MatrixXd& projected,
                                                          const MatrixXd& last) const {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (projected + projected.transpose()));
  const Index m = projected.cols(), b = last.cols(), count = std::min<Index>(wanted(), m);
  Combination found{{VectorXd(count), 0}, MatrixXd(m + b, count)};
  for (Index i = 0; i < count; ++i) {
    auto weights = found.weights.col(i);
    const double theta = eigen.eigenvalues()(m - 1 - i);
    weights.head(m) = eigen.eigenvectors().col(m - 1 - i);
    weights.tail(b) = last * weights.segment(m - b, b) / theta;
    const double tail = weights.tail(b).norm(), length = std::hypot(1.0, tail);
    weights /= length;
    found.ritz.values(i) = 1 / theta;
    if (i < options.eigenvectors)
      found.ritz.residual = std::max(found.ritz.residual, tail / (theta * length));
  }
  return found;
}

// Block Lanczos on (L + shift)^-1 with full reorthogonalisation (Golub, Van Loan, section 10.3.6), until the
// residual is small enough.
Result<Ritz> EigenSolver::Impl::cold() {
  const int b = options.krylov_block, steps = options.krylov_steps, m = b * steps;
  basis.resize(size(), m + b);
  block.resize(size(), b);
  Random random(options.seed);
  for (Index j = 0; j < b; ++j)
    for (Index i = 0; i < size(); ++i) basis(i, j) = random.uniform(-1, 1);
  for (int pass = 0; pass < 2; ++pass) orthonormalize(basis.leftCols(b), scratch);

  MatrixXd projected = MatrixXd::Zero(m, m);
  for (Index filled = b;; filled += b) {
    const bool last = filled == m;
    auto next = basis.middleCols(filled, b);
    if (const auto solved = factor.solve(basis.col(filled - b).data(), b, next.data()); !solved)
      return forward(solved);
    MatrixXd coefficients = MatrixXd::Zero(filled, b), below = MatrixXd::Identity(b, b), part(filled, b);
    for (int pass = 0; pass < 2; ++pass) {
      transposed_product(basis.leftCols(filled), next, part);
      product(basis.leftCols(filled), part, next, 1, -1);
      coefficients += part * below;
      below = orthonormalize(next, scratch) * below;
    }
    projected.block(0, filled - b, filled, b) = coefficients;
    if (filled >= wanted() || last) {
      Combination found = combine(projected.topLeftCorner(filled, filled), below);
      if (found.ritz.residual <= options.tolerance || last) {
        ritz_vectors.resize(size(), found.weights.cols());
        product(basis.leftCols(filled + b), found.weights, ritz_vectors);
        return std::move(found.ritz);
      }
    }
    projected.block(filled, filled - b, b, b) = below;
  }
}

// Inverse iteration on the previous vectors V and Rayleigh-Ritz in the span of Y = (L + shift)^-1 V, for
// which Y' (L + shift) Y = Y' V is a by-product of the solve.
Result<Ritz> EigenSolver::Impl::warm(const EigenPairs& previous) {
  const Index count = previous.vectors.cols();
  const std::vector<int>& order = factor.order();
  basis.resize(size(), count);
  for (Index j = 0; j < count; ++j)
    for (Index i = 0; i < size(); ++i) basis(i, j) = previous.vectors(order[i], j);
  ritz_vectors.resize(size(), count);
  block.resize(size(), count);
  Ritz ritz;
  for (int step = 0; step < options.warm_steps; ++step) {
    if (step > 0) basis.swap(ritz_vectors);
    if (const auto solved = factor.solve(basis.data(), static_cast<int>(count), block.data()); !solved)
      return forward(solved);
    MatrixXd mass(count, count), cross(count, count), start(count, count);
    transposed_product(block, block, mass);
    transposed_product(block, basis, cross);
    transposed_product(basis, basis, start);
    // The lengths of the columns of Y differ by 10^4; the generalised problem wants them equal.
    const VectorXd scale = mass.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const MatrixXd scaled_mass = scale.asDiagonal() * mass * scale.asDiagonal();
    const MatrixXd scaled_cross =
        scale.asDiagonal() * (0.5 * (cross + cross.transpose())) * scale.asDiagonal();
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(scaled_cross, scaled_mass);
    if (eigen.info() != Eigen::Success || !eigen.eigenvalues().allFinite())
      return cold();  // the previous vectors are dependent here
    const MatrixXd combine = scale.asDiagonal() * eigen.eigenvectors();
    product(block, combine, ritz_vectors);
    ritz.values = eigen.eigenvalues();
    ritz.residual = 0;
    for (Index i = 0; i < std::min<Index>(options.eigenvectors, count); ++i) {
      const auto c = combine.col(i);
      const double mu = ritz.values(i);
      const double square = c.dot(start * c) - 2 * mu * c.dot(cross * c) + mu * mu * c.dot(mass * c);
      ritz.residual = std::max(ritz.residual, std::sqrt(std::max(square, 0.0)));
    }
  }
  return ritz;
}

EigenPairs EigenSolver::Impl::to_pixels(const Ritz& ritz) const {
  EigenPairs pairs{width, height, VectorXd(ritz.values.size()), {}, ritz.residual};
  pairs.vectors.resize(size(), ritz.values.size());
  const std::vector<int>& order = factor.order();
  for (Index j = 0; j < ritz.values.size(); ++j) {
    // Eigenvectors have no sign of their own; the largest entry decides, so that neighbours in time agree.
    Index largest = 0;
    ritz_vectors.col(j).cwiseAbs().maxCoeff(&largest);
    const double sign = ritz_vectors(largest, j) < 0 ? -1 : 1;
    for (Index i = 0; i < size(); ++i)
      pairs.vectors(order[i], j) = static_cast<float>(sign * ritz_vectors(i, j));
    pairs.values(j) = std::max(ritz.values(j) - kShift, 0.0);
  }
  return pairs;
}

EigenSolver::EigenSolver(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EigenSolver::EigenSolver(EigenSolver&&) noexcept = default;
EigenSolver& EigenSolver::operator=(EigenSolver&&) noexcept = default;
EigenSolver::~EigenSolver() = default;

Result<EigenSolver> EigenSolver::create(int width, int height, const SpectralOptions& options) {
  if (const auto good = options.check(); !good) return forward(good);
  const double space = 2.0 * options.krylov_block * (options.krylov_steps + 1);
  if (width < 3 || height < 3 || static_cast<double>(width) * height < space)
    return fail(ErrorCode::InvalidArgument,
                text("a picture of ", width, "x", height, " is too small for spectral matting with ",
                     options.eigenvectors, " eigenvectors; it needs ", space, " pixels"));
  if (static_cast<double>(width) * height > 4e6)
    return fail(ErrorCode::InvalidArgument,
                text("a picture of ", width, "x", height,
                     " is too large for spectral matting; scale it to 512x384 or so"));
  auto factor = GridFactor::create(width, height);
  if (!factor) return forward(factor);
  auto impl = std::make_unique<Impl>(std::move(*factor));
  impl->width = width;
  impl->height = height;
  impl->options = options;
  return EigenSolver(std::move(impl));
}

Result<EigenPairs> EigenSolver::solve(const Image& picture, const EigenPairs* previous) {
  Impl& s = *impl_;
  if (picture.width != s.width || picture.height != s.height ||
      (picture.channels != 1 && picture.channels != 3))
    return fail(ErrorCode::InvalidArgument,
                text("spectral matting was set up for ", s.width, "x", s.height, " and got a picture of ",
                     picture.width, "x", picture.height, " with ", picture.channels, " channels"));
  if (one_colour(picture))
    return fail(ErrorCode::BadData,
                text("the ", s.width, "x", s.height,
                     " picture has one colour: there is nothing that matting could tell apart"));
  const bool warm = previous && !previous->empty() && previous->vectors.cols() >= s.options.eigenvectors;
  if (warm && (previous->width != s.width || previous->height != s.height))
    return fail(ErrorCode::InvalidArgument,
                text("the previous frame's eigenvectors are ", previous->width, "x", previous->height,
                     ", this picture is ", s.width, "x", s.height));
  build_stencil(picture, s.options.laplacian.epsilon, {}, s.stencil);
  if (const auto done = s.factor.factor(s.stencil, kShift); !done) return forward(done);
  const auto ritz = warm ? s.warm(*previous) : s.cold();
  if (!ritz) return forward(ritz);
  return s.to_pixels(*ritz);
}

std::size_t EigenSolver::bytes() const {
  const Impl& s = *impl_;
  const auto doubles = s.basis.size() + s.block.size() + s.scratch.size() + s.ritz_vectors.size() +
                       static_cast<Index>(s.stencil.pixels()) * LaplacianStencil::kSteps;
  return s.factor.bytes() + sizeof(double) * static_cast<std::size_t>(doubles) +
         s.stencil.pixels() * 13 * 8;  // where the factor's entries come from
}

}  // namespace floatstage::matting
