#pragma once

#include <array>
#include <cmath>
#include <cstdint>

// Private to the stage.
namespace floatstage::matting {

/// 8-bit values by ratio rather than by difference, 0 … 255: what tells dark hair from a dark wall is as much
/// as what tells a shirt from a lit one. The dark end is flattened where an 8-bit camera shows only noise.
inline const std::array<std::uint8_t, 256>& tone() {
  static const std::array<std::uint8_t, 256> table = [] {
    constexpr double kBlack = 8;  // 8-bit steps
    std::array<std::uint8_t, 256> t{};
    for (std::size_t v = 0; v < t.size(); ++v)
      t[v] = static_cast<std::uint8_t>(
          std::lround(255 * std::log1p(static_cast<double>(v) / kBlack) / std::log1p(255 / kBlack)));
    return t;
  }();
  return table;
}

}  // namespace floatstage::matting
