#pragma once

#include <cstddef>

#include "core/frame.h"

namespace floatstage::capture {

// Pictures that show nothing: one colour all over, as cameras give before they have started and converters
// when they lose the signal.

/// Whether all of an uncompressed picture is one colour, but for a few steps of noise. Most pictures are
/// found to be none after some pixels.
bool is_one_colour(const ImageLayout& layout, const std::byte* pixels);

/// From the tenth to the ninetieth percentile of the values along a picture's border, 8-bit steps: what is
/// behind the subject differs by that much in itself.
int border_spread(const ImageLayout& layout, const std::byte* pixels);

/// A camera whose pictures usually spread by less than that along the border may show one colour and mean it:
/// nobody before black cloth.
inline constexpr int kLeastBorderSpread = 12;

}  // namespace floatstage::capture
