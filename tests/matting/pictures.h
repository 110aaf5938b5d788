#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/frame.h"
#include "core/image.h"
#include "core/matte.h"
#include "core/random.h"
#include "matting/keyers/backing.h"

namespace floatstage::matting {

/// A stage for keyer tests: a plain backing, unevenly lit, and a disc of another colour in the middle that
/// covers its border pixels partly; and the truth.
struct Scene {
  Rgb backing{40, 120, 60}, subject{180, 60, 50};
  int width = 160, height = 120;
  double radius = 30;     ///< px; 0: nobody there
  double noise = 0;       ///< standard deviation, 8-bit steps
  double vignette = 0.5;  ///< light lost at the corners
};

inline double disc_coverage(const Scene& s, int x, int y) {
  const double d = std::hypot(x + 0.5 - s.width / 2.0, y + 0.5 - s.height / 2.0);
  return s.radius <= 0 ? 0 : std::clamp(s.radius - d + 0.5, 0.0, 1.0);
}

inline Image photograph(const Scene& s, std::uint64_t seed = 1) {
  Random random(seed);
  Image image(s.width, s.height, 3);
  const double corner = std::hypot(s.width, s.height) / 2;
  for (int y = 0; y < s.height; ++y) {
    for (int x = 0; x < s.width; ++x) {
      const double light = 1 - s.vignette * std::hypot(x - s.width / 2.0, y - s.height / 2.0) / corner;
      const double a = disc_coverage(s, x, y);
      const double rgb[3] = {a * s.subject.r + (1 - a) * light * s.backing.r,
                             a * s.subject.g + (1 - a) * light * s.backing.g,
                             a * s.subject.b + (1 - a) * light * s.backing.b};
      for (int c = 0; c < 3; ++c) {
        const double noisy = rgb[c] + (s.noise > 0 ? s.noise * random.normal() : 0);
        image.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(std::lround(noisy), 0L, 255L));
      }
    }
  }
  return image;
}

inline Matte truth(const Scene& s) {
  Image alpha(s.width, s.height, 1);
  for (int y = 0; y < s.height; ++y)
    for (int x = 0; x < s.width; ++x)
      *alpha.at(x, y) = static_cast<std::uint8_t>(std::lround(255 * disc_coverage(s, x, y)));
  return make_matte({}, alpha);
}

inline Image empty_stage(Scene s, std::uint64_t seed = 2) {
  s.radius = 0;
  return photograph(s, seed);
}

}  // namespace floatstage::matting
