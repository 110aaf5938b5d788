#pragma once

#include "core/image.h"
#include "core/result.h"

namespace floatstage::matting {

/// Brings a small matte to its photograph's size: opacity as an affine function of colour in small
/// windows (He, Sun, "Fast Guided Filter", 2015; the model of the matting Laplacian). `photograph` has 1 or 3
/// channels and the aspect of `matte`, which has one. A matte of the photograph's size comes back as it is.
Result<Image> guided_upsample(const Image& matte, const Image& photograph);

}  // namespace floatstage::matting
