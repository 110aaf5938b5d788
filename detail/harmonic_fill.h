#pragma once

#include <cstdint>
#include <vector>

#include "detail/float_picture.h"

namespace floatstage::detail {

/// Fills the pixels that are not fixed so smoothly that each is the mean of its neighbours: Laplace's
/// equation with the fixed pixels as boundary, the picture's edge reflecting. Four numbers a pixel at once.
/// Without a fixed pixel all become zero. Multigrid from coarse to fine, then V-cycles until no value moves
/// by more than `tolerance`. `fixed`: one a pixel. The values of pixels that are not fixed are not read. Not
/// threaded. Returns the cycles that it took.
int fill_harmonically(LightPicture& picture, const std::vector<std::uint8_t>& fixed, float tolerance = 1e-4F);

}  // namespace floatstage::detail
