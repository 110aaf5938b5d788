#pragma once

#include "core/image.h"

namespace floatstage::studio {

/// `picture` (RGBA, straight alpha) at another size, bilinearly with colours weighed by their opacity: no
/// fringe of what lies behind. `out` has its size and four channels; its memory is used.
void enlarge(const Image& picture, Image& out);

}  // namespace floatstage::studio
