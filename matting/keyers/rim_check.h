#pragma once

#include <string_view>

#include "core/frame.h"
#include "core/image.h"
#include "core/result.h"

// Private to the stage.
namespace floatstage::matting {

/// Whether a keyer that learns its backing from the picture's rim can have seen any: Unsupported, with a
/// sentence that names the camera and says what to do, where most of the rim of `alpha` is subject. A matte
/// of such a picture would be wrong without a word; an absent one does not carve. `sought`: what the keyer
/// looks for, "green or blue cloth". Pictures without a rim (under 34 pixels) pass.
Result<void> check_rim(const Image& alpha, const FrameInfo& info, std::string_view sought);

/// The same where the share of the rim that is subject was found already.
Result<void> check_rim(double subject_share, const FrameInfo& info, std::string_view sought);

/// Width of the rim in which keyers look for their backing, px; 0 of a picture too small to have one.
int rim_width(int width, int height);

}  // namespace floatstage::matting
