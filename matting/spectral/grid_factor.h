#pragma once

#include <memory>
#include <span>

#include "core/result.h"
#include "matting/laplacian_stencil.h"

// Private to the stage.
namespace floatstage::matting {

/// The sparse Cholesky factor of L + diagonal on a pixel grid of one size: analysed once, factored for every
/// picture, workspaces kept. Not thread safe; one a worker. All vectors are in elimination order: order()[i]
/// is the pixel of entry i.
class GridFactor {
 public:
  /// Unsupported when the linear algebra library refuses (out of memory).
  static Result<GridFactor> create(int width, int height);
  GridFactor(GridFactor&&) noexcept;
  GridFactor& operator=(GridFactor&&) noexcept;
  ~GridFactor();

  const std::vector<int>& order() const;

  /// Factors `laplacian` + `shift` on the diagonal. The stencil has the size given to create(). Unsupported
  /// when the sum is not positive definite or memory ran out.
  Result<void> factor(const LaplacianStencil& laplacian, double shift);

  /// out = (L + shift)^-1 right, `columns` columns of pixels() numbers each. May not alias.
  Result<void> solve(const double* right, int columns, double* out);

  std::size_t nonzeros() const;  ///< of the factor, with the zeros that supernodes store
  std::size_t bytes() const;     ///< held by the library at its peak so far

 private:
  struct Impl;
  explicit GridFactor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::matting
