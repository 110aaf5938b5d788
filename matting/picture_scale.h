#pragma once

#include "core/image.h"
#include "matting/spectral/spectral_matting.h"

// Private to the stage.
namespace floatstage::matting {

/// The picture at another size: area means when it shrinks, bicubic when it grows. The picture itself when
/// the size fits.
Image scaled(const Image& picture, int width, int height);

/// An opinion at another size. A stroke thinner than a pixel of the new size keeps its opacity there and
/// loses weight.
MatteConstraint scaled(const MatteConstraint& opinion, int width, int height);

}  // namespace floatstage::matting
