#pragma once

#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// A key's matte with what a coarse cut of the same picture shows to be wrong with it. `picture` is RGB,
/// `key` one channel of its size, `cut` (0 or 255) smaller. Where the two differ in a part that is at least
/// five of the cut's pixels thick, the cut, refined by closed form, takes the key's place, two of its pixels
/// around included; thinner differences are outlines, hair and fingers, of which the key knows more. Where
/// the key lacks more than a twentieth of the cut's inside it has lost the subject's pattern, and the whole
/// inside counts. Else the result is the key. Errors: InvalidArgument for sizes that do not fit.
Result<Image> corrected_key(const Image& picture, const Image& key, const Image& cut);

/// A mask of a whole picture as a cut for corrected_key(): at most 480 px a side, where parts are told from
/// outlines and strands.
Image coarse_cut(const Image& mask);

}  // namespace floatstage::pipeline
