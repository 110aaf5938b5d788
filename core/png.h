#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/image.h"
#include "core/result.h"

namespace floatstage {

/// A picture that claims more is refused before it costs memory: 100 Mpx is the largest sensor's.
constexpr std::uint64_t kMostPngPixels = 112'000'000;

/// Reads a PNG of at most 32768 px a side and kMostPngPixels as 1 (grey), 3 (RGB) or 4 (RGBA) channels of 8
/// bits; palettes and 1-bit images are expanded, 16-bit ones reduced. Errors name the file: NotFound, Io,
/// BadData when it is not a whole PNG.
Result<Image> load_png(const std::filesystem::path& file);
Result<Image> decode_png(std::span<const std::byte> bytes, std::string_view name_for_errors);

/// Writes 1, 3 or 4 channels, to a temporary name first.
Result<void> save_png(const Image& image, const std::filesystem::path& file);

/// The bytes of a PNG that is packed as runs of equal bytes, without filters: for mattes, of which that makes
/// smaller files in a third of the time (docs/adr/0193). Of photographs it makes large ones.
Result<std::string> encode_png_of_runs(const Image& image);

/// The same picture with 16 bits a channel (v * 257, big-endian in the file as PNG wants it): for programs
/// that expect them.
Result<void> save_png16(const Image& image, const std::filesystem::path& file);

}  // namespace floatstage
