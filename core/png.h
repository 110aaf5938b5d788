#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "core/image.h"
#include "core/result.h"

namespace floatstage {

/// Reads an 8-bit PNG as 1 (grey), 3 (RGB) or 4 (RGBA) channels; palettes and 1-bit images are expanded, 16-bit ones reduced.
Result<Image> load_png(const std::filesystem::path& file);

/// Writes 1, 3 or 4 channels, to a temporary name first. `level` is zlib's: 1 fast … 9 small.
Result<void> save_png(const Image& image, const std::filesystem::path& file, int level = 3);

}  // namespace floatstage
