#pragma once

#include <vector>

#include "core/result.h"
#include "matting/laplacian_stencil.h"

// Private to the stage.
namespace floatstage::matting {

/// Solves (L + diag(weight)) a = weight * value over the pixels of `stencil` where `active` is not 0; the
/// others do not take part (their rows of L must be 0, or they are ignored: natural boundary). One column;
/// sparse Cholesky, or solve_held_band() where every pixel is held. The result is 0 off the active pixels.
/// Unsupported when the library refuses.
Result<std::vector<double>> solve_band(const LaplacianStencil& stencil,
                                       const std::vector<std::uint8_t>& active,
                                       const std::vector<double>& weight, const std::vector<double>& value);

}  // namespace floatstage::matting
