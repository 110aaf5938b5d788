#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/image.h"
#include "matting/foreground.h"

namespace floatstage::matting {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Rgb&) const = default;
};

/// The colour of the cloth in RGB pictures: the mean of the pixels in the mode of the chromaticity histogram
/// of the saturated green or blue pixels near the borders. Chromaticity (colour over brightness) puts the lit
/// and the shaded cloth into one bin. Nothing when less than 2 % of the border shows such a colour.
std::optional<Rgb> sample_backing(const std::vector<Image>& pictures);

/// The channel in which a cloth of that colour leads; green unless blue does.
BackingChannel backing_channel(Rgb color);

}  // namespace floatstage::matting
