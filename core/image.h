#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace floatstage {

/// 8-bit pixels in memory that we own: rows top first, tightly packed, channels interleaved.
/// 1 channel is grey or alpha, 3 is RGB, 4 is RGBA with straight (not premultiplied) alpha.
struct Image {
  int width = 0, height = 0, channels = 0;
  std::vector<std::uint8_t> pixels;  ///< width * height * channels bytes

  Image() = default;
  Image(int w, int h, int c, std::uint8_t fill = 0)
      : width(w), height(h), channels(c), pixels(static_cast<std::size_t>(w) * h * c, fill) {}

  bool empty() const { return pixels.empty(); }
  /// Keeps the memory. What the pixels are then is not said.
  void resize(int w, int h, int c) {
    width = w;
    height = h;
    channels = c;
    pixels.resize(static_cast<std::size_t>(w) * h * c);
  }
  std::size_t offset(int x, int y) const { return (static_cast<std::size_t>(y) * width + x) * channels; }
  std::uint8_t* at(int x, int y) { return pixels.data() + offset(x, y); }
  const std::uint8_t* at(int x, int y) const { return pixels.data() + offset(x, y); }
  bool operator==(const Image&) const = default;
};

}  // namespace floatstage
