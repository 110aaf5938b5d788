#include "matting/matting_laplacian.h"

#include <cmath>

#include "core/text.h"
#include "matting/laplacian_stencil.h"

namespace floatstage::matting {
namespace {

constexpr int kReach = 2;  // pixels that share a window are at most this many rows and columns apart

// Columns of a stencil whose entries are kept where `keep` says so; the diagonal always is.
template <class Keep>
Eigen::SparseMatrix<double> to_sparse(const LaplacianStencil& stencil, Keep keep) {
  const int width = stencil.width, height = stencil.height;
  const auto for_each_entry = [&](int x, int y, auto visit) {
    for (int dy = -kReach; dy <= kReach; ++dy) {
      if (y + dy < 0 || y + dy >= height) continue;
      for (int dx = -kReach; dx <= kReach; ++dx) {
        if (x + dx < 0 || x + dx >= width) continue;
        const double value = stencil.at(x, y, dx, dy);
        if ((dx == 0 && dy == 0) || keep(value)) visit((y + dy) * width + x + dx, value);
      }
    }
  };
  const Eigen::Index n = static_cast<Eigen::Index>(stencil.pixels());
  Eigen::SparseMatrix<double> matrix(n, n);
  int* starts = matrix.outerIndexPtr();
  int count = 0;
  for (int y = 0, p = 0; y < height; ++y)
    for (int x = 0; x < width; ++x, ++p) {
      starts[p] = count;
      for_each_entry(x, y, [&](int, double) { ++count; });
    }
  starts[n] = count;
  matrix.resizeNonZeros(count);
  int* rows = matrix.innerIndexPtr();
  double* values = matrix.valuePtr();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for_each_entry(x, y, [&](int row, double value) {
        *rows++ = row;
        *values++ = value;
      });
  return matrix;
}

}  // namespace

Result<void> LaplacianOptions::check() const {
  if (!(epsilon >= 1e-9 && epsilon <= 1e-2))
    return fail(ErrorCode::InvalidArgument,
                text("epsilon of the matting Laplacian is ", epsilon, "; it must lie between 1e-9 and 1e-2"));
  return {};
}

Result<Eigen::SparseMatrix<double>> matting_laplacian(const Image& picture, const LaplacianOptions& options,
                                                      const Image& known) {
  if (const auto good = options.check(); !good) return forward(good);
  if (picture.channels != 1 && picture.channels != 3)
    return fail(ErrorCode::InvalidArgument, text("a picture of ", picture.channels,
                                                 " channels has no matting Laplacian; give grey or RGB"));
  if (picture.width < 3 || picture.height < 3)
    return fail(ErrorCode::InvalidArgument, text("a picture of ", picture.width, "x", picture.height,
                                                 " is smaller than one 3x3 window of the matting Laplacian"));
  if (static_cast<double>(picture.width) * picture.height > 60e6)
    return fail(ErrorCode::InvalidArgument,
                text("a picture of ", picture.width, "x", picture.height,
                     " has too many pixels for a matting Laplacian; scale it down"));
  if (!known.empty() &&
      (known.channels != 1 || known.width != picture.width || known.height != picture.height))
    return fail(ErrorCode::InvalidArgument,
                text("the mask of known pixels is ", known.width, "x", known.height, " with ", known.channels,
                     " channels, the picture ", picture.width, "x", picture.height, "; they must agree"));
  LaplacianStencil stencil;
  build_stencil(picture, options.epsilon, known, stencil);
  if (known.empty()) return to_sparse(stencil, [](double) { return true; });
  return to_sparse(stencil, [](double value) { return value != 0; });
}

}  // namespace floatstage::matting
