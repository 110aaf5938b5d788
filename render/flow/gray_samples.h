#pragma once

#include <algorithm>
#include <cstddef>

namespace floatstage::render {

/// A plane of width * height between its pixels; beyond its border as at the border.
template <class T>
float bilinear_sample(const T* plane, int width, int height, float x, float y) {
  x = std::min(std::max(0.F, x), static_cast<float>(width - 1));
  y = std::min(std::max(0.F, y), static_cast<float>(height - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int right = x0 + 1 < width ? 1 : 0;
  const std::ptrdiff_t below = y0 + 1 < height ? width : 0;
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const T* at = plane + static_cast<std::ptrdiff_t>(y0) * width + x0;
  const auto value = [&](std::ptrdiff_t offset) { return static_cast<float>(at[offset]); };
  return (value(0) * (1 - fx) + value(right) * fx) * (1 - fy) +
         (value(below) * (1 - fx) + value(below + right) * fx) * fy;
}

/// What is left of confidence: all without a fault, half where it is usual, nothing from twice that on.
inline float confidence_left(float fault, float usual) {
  return fault < 2 * usual ? 1 - fault / (2 * usual) : fault > 0 ? 0.F : 1.F;
}

}  // namespace floatstage::render
