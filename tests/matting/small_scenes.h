#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/image.h"
#include "core/random.h"

namespace floatstage::matting {

/// A picture that spectral matting can take apart, with the truth: a soft-edged disc with a gradient before
/// four fields of other colours. `shift` moves the disc to the right, in px.
struct DiscPicture {
  Image rgb, alpha;
};

inline DiscPicture disc_picture(int width, int height, double shift = 0, double noise = 1) {
  Random random(11);
  DiscPicture scene{Image(width, height, 3), Image(width, height, 1)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double dx = x + 0.5 - width * 0.45 - shift, dy = y + 0.5 - height * 0.5;
      const double a = std::clamp((height * 0.3 - std::hypot(dx, dy)) / 4 + 0.5, 0.0, 1.0);
      const bool right = x > width * 0.55, low = y > height * 0.4;
      const double back[3] = {right ? 60.0 : 30.0, low ? 130.0 : 90.0, right == low ? 40.0 : 160.0};
      const double front[3] = {200 + dx * 0.5, 120 + dy * 0.5, 60};
      for (int c = 0; c < 3; ++c) {
        const double value = a * front[c] + (1 - a) * back[c] + (noise > 0 ? noise * random.normal() : 0);
        scene.rgb.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
      }
      *scene.alpha.at(x, y) = static_cast<std::uint8_t>(std::lround(255 * a));
    }
  }
  return scene;
}

/// Mean squared difference of two mattes of one size, opacities in 0..1.
inline double mean_square(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double d = (a.pixels[i] - b.pixels[i]) / 255.0;
    sum += d * d;
  }
  return sum / static_cast<double>(a.pixels.size());
}

}  // namespace floatstage::matting
