#pragma once

#include <span>

#include "core/image.h"
#include "matting/keyers/plate.h"

namespace floatstage::matting {

/// Where a photograph is for certain unlike the empty stage, and where like it: one channel each, of its
/// size, 255 there. A pixel is either only amid others that are, and unlike only if at least half as much as
/// they: at outlines, in strands, shadows and clothes of the stage's colours both are 0.
struct PlateWord {
  Image unlike, alike;
};

/// `plate` and `picture` (RGB) have one size (our bug otherwise). Deterministic, one thread.
PlateWord word_of(const Plate& plate, const Image& picture);

/// What that tells about a cut that was made at a smaller size, for refine_matte(): of each pixel of the
/// photograph 255 where it is unlike the stage and of the cut's subject, or as near to it as closed form
/// looks for outlines; 0 where it is like the stage and the cut has no subject; 128 where that is left open.
/// `cut`: one channel, not 0 where the subject is; `odds`: of its size, log of how much likelier subject is
/// there, by its own pixels: beside the cut's subject a shadow in another colour than its light's is unlike
/// the plate, too, and only what is likely counts. Deterministic, one thread.
Image known_by_plate(const PlateWord& word, const Image& cut, std::span<const float> odds);

/// Of a smaller picture's pixels 255 where any of the photograph's is unlike the stage for certain: a finger
/// is as thin as an outline there, and is none.
Image unlike_within(const PlateWord& word, int width, int height);

}  // namespace floatstage::matting
