#pragma once

#include <cstdint>

#include "core/frame.h"

namespace floatstage::capture {

/// FNV-1a over the visible bytes of a frame's rows: equal for equal pictures whatever their stride.
inline std::uint64_t pixels_hash(const Frame& frame) {
  std::uint64_t hash = 14695981039346656037ull;
  const std::size_t row = packed_layout(frame.layout.format, frame.layout.width, 1).stride;
  for (int y = 0; y < frame.layout.height; ++y) {
    const std::byte* bytes = frame.pixels.get() + static_cast<std::size_t>(y) * frame.layout.stride;
    for (std::size_t x = 0; x < row; ++x)
      hash = (hash ^ std::to_integer<std::uint64_t>(bytes[x])) * 1099511628211ull;
  }
  return hash;
}

}  // namespace floatstage::capture
