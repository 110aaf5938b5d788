#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/random.h"

namespace floatstage::render::test {

/// A smooth texture with detail at several sizes, displaced by (dx, dy).
inline std::vector<std::uint8_t> wavy(int width, int height, double dx, double dy) {
  std::vector<std::uint8_t> gray;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = x - dx, v = y - dy;
      gray.push_back(static_cast<std::uint8_t>(
          std::lround(128 + 45 * std::sin(u * 0.31) * std::cos(v * 0.23) +
                      45 * std::sin(0.13 * u + 0.19 * v) + 25 * std::sin(0.047 * u - 0.031 * v))));
    }
  return gray;
}

/// The same with a grain of about two pixels, by whole pixels.
inline std::vector<std::uint8_t> grainy(int width, int height, int dx, int dy) {
  auto noise = [](int x, int y) {
    return static_cast<double>(
               mix(static_cast<std::uint64_t>(x + 5000) * 10007 + static_cast<std::uint64_t>(y + 5000)) %
               1024) /
           1024;
  };
  std::vector<std::uint8_t> gray = wavy(width, height, dx, dy);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int v = -1; v <= 1; ++v)
        for (int u = -1; u <= 1; ++u) sum += noise(x - dx + u, y - dy + v);
      std::uint8_t& g = gray[static_cast<std::size_t>(y * width + x)];
      g = static_cast<std::uint8_t>(std::lround(0.6 * g + 100 * sum / 9));
    }
  return gray;
}

/// A proxy's picture: a disc (255 evidence) with a hole in its evidence (128), nothing (0) around it.
inline std::vector<std::uint8_t> disc(int width, int height) {
  std::vector<std::uint8_t> state;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double radius =
          std::hypot((x - 0.5 * width) / (0.42 * width), (y - 0.5 * height) / (0.42 * height));
      const bool hole = std::hypot(x - 0.6 * width, y - 0.4 * height) < 0.1 * height;
      state.push_back(radius > 1 ? 0 : hole ? 128 : 255);
    }
  return state;
}

}  // namespace floatstage::render::test
