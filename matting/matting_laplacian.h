#pragma once

#include <Eigen/SparseCore>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::matting {

struct LaplacianOptions {
  /// How far the colours of a window may leave a line before it costs as much as a change of opacity. Added
  /// to the colour covariance as epsilon / 9, colours in 0..1. Small keeps hair, large smooths noise; 1e-9 …
  /// 1e-2.
  double epsilon = 1e-7;

  Result<void> check() const;
};

/// The matting Laplacian of a picture (Levin, Lischinski, Weiss, "A Closed-Form Solution to Natural Image
/// Matting", 2008, eq. 12; Levin, Rav-Acha, Lischinski, "Spectral Matting", 2008, eq. 10): the quadratic form
/// alpha' L alpha is small where, in every 3x3 window, opacity is an affine function of colour.
///
/// Pixel (x, y) is unknown y * width + x. The result is symmetric, both halves stored, rows of a column in
/// ascending order, at most 25 a column. It is positive semidefinite to rounding and its rows sum to 0: every
/// window's block I - (1 + (I_i - mu)' (Sigma + epsilon/9)^-1 (I_j - mu)) / 9 is made as I - 11'/9 - Q1 Q1'
/// from the thin QR [D; sqrt(epsilon) 1] = [Q1; Q2] R of its centred colours D, never through an inverse of
/// the covariance: that makes L indefinite on real photographs. The pattern depends on the size alone when
/// `known` is empty.
///
/// `picture`: 1 or 3 channels (grey counts as RGB with equal channels), at least 3x3. `known`: empty, or one
/// channel of the picture's size; windows whose nine pixels are all not 0 are left out, and so are entries
/// that only they would give (a trimap's known inside costs nothing). Deterministic; one thread; about 0.25
/// microseconds a pixel. Errors: InvalidArgument naming the size, channel count or option that does not fit.
Result<Eigen::SparseMatrix<double>> matting_laplacian(const Image& picture,
                                                      const LaplacianOptions& options = {},
                                                      const Image& known = {});

}  // namespace floatstage::matting
