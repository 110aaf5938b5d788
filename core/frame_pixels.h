#pragma once

#include <algorithm>
#include <cstdint>

#include "core/frame.h"

// Private to core/: how a frame's bytes are read.
namespace floatstage {

/// That the frame has pixels, of a format that can be read here, and as many as its layout says.
Result<void> check_readable(const Frame& frame);

inline std::uint8_t clamp_byte(int v) { return static_cast<std::uint8_t>(std::clamp(v, 0, 255)); }

/// BT.601, limited range, 8 fractional bits.
inline void yuv_to_rgb(int y, int u, int v, std::uint8_t* rgb) {
  const int c = 298 * (y - 16), d = u - 128, e = v - 128;
  rgb[0] = clamp_byte((c + 409 * e + 128) >> 8);
  rgb[1] = clamp_byte((c - 100 * d - 208 * e + 128) >> 8);
  rgb[2] = clamp_byte((c + 516 * d + 128) >> 8);
}

}  // namespace floatstage
