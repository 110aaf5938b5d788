#pragma once

#include <cstdint>
#include <vector>

#include "detail/float_picture.h"

namespace floatstage::detail {

/// How opaque the child is at each of its pixels, 0 to 1 (thesis 4.3.4): the cost of the cheapest way to a
/// pixel that is not the child's, where a step costs the gradient's L1 norm (Eq. 4.5, 4.6), of the channel in
/// which it is largest, over 0.4 of the largest cost, at most 1 (Eq. 4.7). What nothing happens in still
/// costs a little, so that the sky becomes opaque too. `child`: 1 where the child is used.
Field blending_mask(const LightPicture& picture, const std::vector<std::uint8_t>& child);

}  // namespace floatstage::detail
