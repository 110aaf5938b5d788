#pragma once

#include "core/frame.h"
#include "core/matte.h"

namespace floatstage::studio {

/// The pixels of a width x height photograph around everything that a matte made at 1/factor of its size does
/// not call background, with a border wide enough for smooth reading. Empty when there is no subject.
PixelBox subject_box(const Matte& small, int factor, int width, int height);

/// A matte made at 1/factor of a photograph's size, bilinearly at the photograph's pixels within `box`. One
/// channel.
Image enlarged(const Matte& small, int factor, const PixelBox& box);

}  // namespace floatstage::studio
