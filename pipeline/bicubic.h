#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/image.h"

namespace floatstage::pipeline {

/// The weights of the four samples around a place `t` (0 … 1) between the middle two (Catmull-Rom).
inline std::array<double, 4> catmull_rom(double t) {
  return {((-0.5 * t + 1) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1, ((-1.5 * t + 2) * t + 0.5) * t,
          (0.5 * t - 0.5) * t * t};
}

/// One channel of an image at a point (corner convention: the first pixel's centre is at 0.5, 0.5),
/// unclamped; the border is repeated.
inline double read_bicubic(const Image& image, double px, double py, int channel) {
  const double x = px - 0.5, y = py - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const std::array<double, 4> wx = catmull_rom(x - x0), wy = catmull_rom(y - y0);
  double sum = 0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      sum += wx[static_cast<std::size_t>(i)] * wy[static_cast<std::size_t>(j)] *
             image.at(std::clamp(x0 + i - 1, 0, image.width - 1),
                      std::clamp(y0 + j - 1, 0, image.height - 1))[channel];
  return sum;
}

}  // namespace floatstage::pipeline
