#pragma once

#include <algorithm>
#include <cmath>

#include "core/image.h"
#include "core/random.h"

namespace floatstage::pipeline {

/// Grey noise blurred by `passes` 3x3 box filters, stretched to about 40 … 215; the same for the same seed.
inline Image texture(int width, int height, std::uint64_t seed = 1, int passes = 2, int channels = 1) {
  Random random(seed);
  std::vector<double> values(static_cast<std::size_t>(width) * height), next(values.size());
  for (double& v : values) v = random.uniform(-1, 1);
  auto at = [&](int x, int y) {
    return values[static_cast<std::size_t>(((y + height) % height) * width + (x + width) % width)];
  };
  for (int pass = 0; pass < passes; ++pass) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double sum = 0;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) sum += at(x + dx, y + dy);
        next[static_cast<std::size_t>(y * width + x)] = sum / 9;
      }
    values.swap(next);
  }
  double largest = 0;
  for (double v : values) largest = std::max(largest, std::abs(v));
  Image image(width, height, channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = static_cast<std::uint8_t>(
        std::lround(127.5 + 87 * values[i / static_cast<std::size_t>(channels)] / largest));
  return image;
}

/// f(value, x, y) for every byte.
template <class F>
Image changed(Image image, F f) {
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < image.channels; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(
            std::clamp(std::lround(f(static_cast<double>(image.at(x, y)[c]), x, y)), 0L, 255L));
  return image;
}

/// The picture moved right and down, wrapping round.
inline Image shifted(const Image& image, int dx, int dy) {
  Image out = image;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.at((x - dx + image.width) % image.width, (y - dy + image.height) % image.height),
                  image.channels, out.at(x, y));
  return out;
}

/// Zeros with 255 in the box.
inline Image box_mask(int width, int height, int x0, int y0, int x1, int y1) {
  Image mask(width, height, 1);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) *mask.at(x, y) = 255;
  return mask;
}

}  // namespace floatstage::pipeline
