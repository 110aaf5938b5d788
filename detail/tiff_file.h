#pragma once

#include <cstdint>
#include <string_view>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::detail {

/// Whether these are the first bytes of a TIFF, of 32 bits or BigTIFF.
bool is_tiff(std::string_view bytes);

/// The first picture of a TIFF as RGB of 8 bits, by libtiff's general reader (palettes, CMYK, YCbCr, Lab, 16
/// bits; planes, strips and tiles). Rows and columns stay as they are stored: turning is the caller's.
/// Errors: BadData and Unsupported, naming it; libtiff's own words go into the sentence, not to a terminal.
Result<Image> decode_tiff(std::string_view bytes, std::int64_t most_pixels, std::string_view name_for_errors);

}  // namespace floatstage::detail
