#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "matting/matting_laplacian.h"

// Spectral matting of single pictures: A. Levin, A. Rav-Acha, D. Lischinski, "Spectral Matting", PAMI 2008;
// thesis section 7.2. Everything here works at the picture's own size: scale large pictures down to 360x240 …
// 512x384 first and carry the matte back up (matting/video/video_matting.h does both).
namespace floatstage::matting {

struct SpectralOptions {
  LaplacianOptions laplacian = {};
  int eigenvectors = 50;  ///< smallest eigenpairs that span the components; 8 … 200
  int components = 10;    ///< K, matting components; 2 … 32
  int krylov_block = 16;  ///< right-hand sides a step of the cold solver; 4 … 64
  int krylov_steps = 12;  ///< steps at most; block * steps must exceed `eigenvectors` by 10 at least
  double tolerance =
      1e-5;  ///< residual at which the cold solver stops early; mattes gain nothing below; 0 … 1
  int warm_steps =
      3;  ///< inverse iterations from the previous frame's vectors; one is enough where little moves; 1 … 4
  double sparsity = 0.9;  ///< gamma of |alpha|^gamma + |1 - alpha|^gamma; (0, 1)
  int newton_steps = 20;  ///< 1 … 100
  int newton_stride = 2;  ///< every n-th pixel in x and y enters the sparsity term; 1 is the reference; 1 … 8
  int clusterings = 4;    ///< k-means restarts; the one of least error starts the Newton iteration; 1 … 64
  std::uint64_t seed = 1;

  Result<void> check() const;
};

/// The smallest eigenpairs of a picture's matting Laplacian, in ascending order of value.
struct EigenPairs {
  int width = 0, height = 0;
  Eigen::VectorXd values;   ///< some more than asked for: the next frame starts from them
  Eigen::MatrixXf vectors;  ///< pixels x values, unit columns; pixel (x, y) is row y * width + x
  double residual = 0;      ///< max over the pairs asked for of |L v - lambda v|

  bool empty() const { return values.size() == 0; }
};

/// Finds eigenpairs by shift-invert: block Krylov from random vectors when cold, inverse iteration with
/// Rayleigh-Ritz from the previous frame's vectors when warm, both on a Cholesky factor of L + 1e-7. The
/// symbolic analysis is done once; the workspaces are kept (about 0.35 GB at 360x240). One a worker: not
/// thread safe, and meant to run on one core, several frames side by side. Deterministic: the same picture
/// and start give the same bytes.
class EigenSolver {
 public:
  /// Errors: what check() finds; InvalidArgument when the size is under 3x3 or has fewer pixels than twice
  /// the Krylov space; Unsupported when memory does not suffice.
  static Result<EigenSolver> create(int width, int height, const SpectralOptions& options = {});
  EigenSolver(EigenSolver&&) noexcept;
  EigenSolver& operator=(EigenSolver&&) noexcept;
  ~EigenSolver();

  /// `picture`: 1 or 3 channels, of the size given to create(). `previous`: eigenpairs of a similar picture
  /// of the same size, or null. Errors: InvalidArgument when a size differs; BadData for a picture of one
  /// colour, whose Laplacian says nothing; Unsupported as above.
  Result<EigenPairs> solve(const Image& picture, const EigenPairs* previous = nullptr);

  std::size_t bytes() const;  ///< memory held for factor and workspaces

 private:
  struct Impl;
  explicit EigenSolver(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// K matting components of a picture: alpha(p, k) is the share of component k in pixel p (eq. 7.2). The
/// shares of a pixel sum to 1; most are near 0 or 1. Some may be empty.
struct MattingComponents {
  int width = 0, height = 0;
  Eigen::MatrixXf alpha;  ///< pixels x K, -0.1 … 1.1 or so

  bool empty() const { return alpha.size() == 0; }
  int count() const { return static_cast<int>(alpha.cols()); }
};

/// Turns eigenvectors into matting components ("Spectral Matting", section 3.2): k-means on the vectors
/// weighted by 1 / sqrt(lambda) as a start, then Newton's method on sum |alpha|^gamma + |1 - alpha|^gamma
/// over linear combinations of the first `options.eigenvectors` vectors whose sum is 1 everywhere. With
/// `previous`, the components of a similar picture, component k continues their component k, so that a choice
/// made once lasts. Deterministic. Errors: what check() finds; InvalidArgument when `previous` differs in
/// size, or there are fewer vectors than asked.
Result<MattingComponents> matting_components(const EigenPairs& pairs, const SpectralOptions& options = {},
                                             const MattingComponents* previous = nullptr);

/// What somebody says about a matte: a wanted opacity a pixel and how much it matters, both one channel, of
/// one size. A scribble or a trimap has weight where it is drawn or known, a keyer or a previous frame's
/// matte everywhere.
struct MatteConstraint {
  Image opacity;  ///< 0 background … 255 subject
  Image weight;   ///< 0 no opinion … 255 full; empty: full everywhere

  bool empty() const { return opacity.empty(); }
};

struct SelectionTerm {
  MatteConstraint opinion;
  double strength = 1;  ///< of the whole term against the others
};

/// Which components are subject, and what that costs.
struct Selection {
  std::vector<bool> chosen;  ///< K of them
  double energy = 0;  ///< mean over all pixels of the weighted squared differences; 0 is complete agreement
};

/// Chooses the subset b of components that minimises (eq. 7.5, squared)
///   sum over terms of strength * sum over pixels of weight * (opacity - sum_k b_k alpha_k)^2
///   + persistence * sum over k of area_k * [b_k differs from previous_k],
/// by enumerating all 2^K subsets through the K x K Gram matrix for K <= 16, greedily (eq. 7.6, both adding
/// and removing) beyond. The subset is never empty unless that is better than every other. Errors:
/// InvalidArgument when there is no term, a size or count differs, or no pixel has weight.
Result<Selection> select_components(const MattingComponents& components,
                                    const std::vector<SelectionTerm>& terms,
                                    const std::vector<bool>& previous = {}, double persistence = 0);

/// A first guess without anybody's help: the balanced split of least matting energy ("Spectral Matting",
/// section 5.2), with the side that touches the picture's border more as background. `laplacian` is of the
/// same picture. Errors: InvalidArgument when sizes differ.
Result<Selection> guess_selection(const MattingComponents& components,
                                  const Eigen::SparseMatrix<double>& laplacian);

/// The sum of the chosen components as an 8-bit matte, clamped.
Image matte_of(const MattingComponents& components, const std::vector<bool>& chosen);

}  // namespace floatstage::matting
