#pragma once

#include "core/image.h"

// Private to the stage.
namespace floatstage::matting {

/// Opacity as an affine function of colour in every window of the small picture, its coefficients brought to
/// the large size and applied to the large picture's colours (He et al., "Guided Image Filtering", 2013, eq.
/// 16, at the small size): edges get the sharpness that the small matte cannot have. `picture` has 1 or 3
/// channels, `matte` one.
Image guided_filter(const Image& picture, const Image& matte);

}  // namespace floatstage::matting
