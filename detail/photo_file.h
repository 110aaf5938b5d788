#pragma once

#include <filesystem>
#include <string_view>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::detail {

/// Whether a file's name says that it is a photograph that load_photo() reads: .jpg .jpeg .png .tif .tiff,
/// in small letters or capitals.
bool has_name_of_photo(const std::filesystem::path& file);

/// A photograph as RGB of 8 bits, as it is to be seen: turned as its EXIF says. JPEG (grey, RGB, CMYK, YCCK),
/// PNG and TIFF (any that libtiff reads), known by their first bytes; 16 bits are reduced to 8, opacity is
/// left out. CMYK is made RGB without its profile. Errors name the file: NotFound, Io, BadData (truncated,
/// damaged, empty), Unsupported (no such format, a JPEG of 12 bits, more than 256 million pixels).
Result<Image> load_photo(const std::filesystem::path& file);

/// The same of bytes in memory.
Result<Image> decode_photo(std::string_view bytes, std::string_view name_for_errors);

}  // namespace floatstage::detail
