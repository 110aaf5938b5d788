#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/image.h"
#include "core/random.h"

namespace floatstage::matting {

/// Frame `frame` of a clip under a blown-out sky: most of it is exactly white, the rest goes there in steps
/// of one channel, with a roof line that moves. Such windows show one line in colour space, or no colour at
/// all.
inline Image saturated_sky(int width, int height, int frame) {
  Image picture(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double up = 1 - static_cast<double>(y) / height;
      const double roof = 0.35 + 0.1 * std::sin(0.11 * (x + 2 * frame));
      std::uint8_t* p = picture.at(x, y);
      if (up < roof) {
        p[0] = static_cast<std::uint8_t>(90 + (x * 7 + y * 13) % 5);
        p[1] = static_cast<std::uint8_t>(60 + (x / 9 + y / 6) % 2 * 40);
        p[2] = 50;
        continue;
      }
      const double glare = 1.35 - 0.5 * std::abs(x - width * 0.4) / width - 0.25 * up;
      const double rgb[3] = {238 * glare, 246 * glare, 255 * glare};
      for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>(std::min(255.0, rgb[c]));
    }
  }
  return picture;
}

/// Frame `frame` of a clip before synthetic green that has one value in every pixel; a disc with a gradient
/// moves.
inline Image flat_green(int width, int height, int frame) {
  Image picture(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double dx = x - width * 0.5 - 2 * frame, dy = y - height * 0.5;
      const bool inside = std::hypot(dx, dy) < height * 0.3;
      std::uint8_t* p = picture.at(x, y);
      p[0] = inside ? static_cast<std::uint8_t>(120 + std::clamp(dx, -60.0, 60.0)) : 0;
      p[1] = inside ? 80 : 177;
      p[2] = inside ? 70 : 64;
    }
  }
  return picture;
}

/// All colours lie on one line, apart from one step in one channel here and there: condition numbers of 1e5.
inline Image one_colour_line(int width, int height) {
  Random random(5);
  Image picture(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int t = static_cast<int>(random.next() % 200);
      std::uint8_t* p = picture.at(x, y);
      for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>(t + 10 * c);
      if (random.next() % 13 == 0) ++p[random.next() % 3];
    }
  }
  return picture;
}

}  // namespace floatstage::matting
