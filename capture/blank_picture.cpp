#include "capture/blank_picture.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace floatstage::capture {
namespace {

constexpr int kMostNoise = 6;  // 8-bit steps, from the darkest to the brightest pixel
constexpr int kStride = 8;     // px from one that is looked at first to the next
constexpr int kBorder = 20;    // of the smaller side, one part

// Values that are compared with one another: colours of a pixel, or of a mosaic's four.
struct Samples {
  const ImageLayout& layout;
  const std::uint8_t* bytes;
  int channels() const {
    if (layout.format == PixelFormat::Rgb8) return 3;
    return layout.format == PixelFormat::BayerRggb8 ? 4 : 1;
  }
  int at(int x, int y, int channel) const {
    switch (layout.format) {
      case PixelFormat::Rgb8:
        return row(y)[3 * x + channel];
      case PixelFormat::Yuyv:
        return row(y)[2 * x];
      case PixelFormat::BayerRggb8: {
        const int whole_x = std::min((x & ~1) + (channel & 1), layout.width - 1),
                  whole_y = std::min((y & ~1) + (channel >> 1), layout.height - 1);
        return row(whole_y)[whole_x];
      }
      default:
        return row(y)[x];
    }
  }
  const std::uint8_t* row(int y) const { return bytes + static_cast<std::size_t>(y) * layout.stride; }
};

bool is_one_colour(const Samples& samples, int stride) {
  std::array<int, 4> low, high;
  low.fill(255), high.fill(0);
  for (int y = 0; y < samples.layout.height; y += stride)
    for (int x = 0; x < samples.layout.width; x += stride)
      for (int c = 0; c < samples.channels(); ++c) {
        const auto i = static_cast<std::size_t>(c);
        const int value = samples.at(x, y, c);
        low[i] = std::min(low[i], value), high[i] = std::max(high[i], value);
        if (high[i] - low[i] > kMostNoise) return false;
      }
  return true;
}

Samples samples_of(const ImageLayout& layout, const std::byte* pixels) {
  return {layout, reinterpret_cast<const std::uint8_t*>(pixels)};
}

}  // namespace

bool is_one_colour(const ImageLayout& layout, const std::byte* pixels) {
  if (layout.format == PixelFormat::Mjpeg || layout.width == 0 || layout.height == 0) return false;
  const Samples samples = samples_of(layout, pixels);
  return is_one_colour(samples, kStride) && is_one_colour(samples, 1);
}

int border_spread(const ImageLayout& layout, const std::byte* pixels) {
  if (layout.format == PixelFormat::Mjpeg) return 0;
  const Samples samples = samples_of(layout, pixels);
  const int border = std::max(1, std::min(layout.width, layout.height) / kBorder);
  int widest = 0;
  for (int c = 0; c < samples.channels(); ++c) {
    std::array<long, 256> histogram{};
    long count = 0;
    for (int y = 0; y < layout.height; ++y)
      for (int x = 0; x < layout.width; ++x) {
        if (y >= border && y < layout.height - border && x == border) x = std::max(x, layout.width - border);
        ++histogram[static_cast<std::size_t>(samples.at(x, y, c))], ++count;
      }
    const auto percentile = [&](long part) {
      long seen = 0;
      int value = 0;
      while (value < 255 && (seen += histogram[static_cast<std::size_t>(value)]) <= part * count / 100)
        ++value;
      return value;
    };
    widest = std::max(widest, percentile(90) - percentile(10));
  }
  return widest;
}

}  // namespace floatstage::capture
