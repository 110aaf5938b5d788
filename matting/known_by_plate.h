#pragma once

#include <span>

#include "core/image.h"
#include "matting/keyers/plate.h"

namespace floatstage::matting {

/// What the empty stage tells for certain about a cut that was made at a smaller size: of each pixel of
/// `picture` 255 where it is amid what the plate does not show, however lit, and of the cut's subject or as
/// near to it as closed form looks for outlines; 0 where it is amid what the plate shows and the cut has no
/// subject; 128 where that is left open, as at outlines, in strands, shadows and clothes of the stage's
/// colours. For refine_matte().
///
/// `plate` and `picture` (RGB) have one size (our bug otherwise). `cut`: one channel, not 0 where the subject
/// is; `odds`: of its size, log of how much likelier subject is there, by its own pixels: beside the cut's
/// subject a shadow in another colour than its light's is unlike the plate, too, and only what is likely
/// counts. Deterministic, one thread.
Image known_by_plate(const Plate& plate, const Image& picture, const Image& cut, std::span<const float> odds);

}  // namespace floatstage::matting
