#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/image.h"

namespace floatstage::detail {

/// Pixels x0 <= x < x1, y0 <= y < y1 of a picture that may be larger.
struct Region {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  bool contains(const Region& other) const {
    return other.x0 >= x0 && other.y0 >= y0 && other.x1 <= x1 && other.y1 <= y1;
  }
  bool operator==(const Region&) const = default;
};

inline Region common(const Region& a, const Region& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}
/// Larger by `by` pixels all around, as far as the picture `whole` reaches.
inline Region grown(const Region& r, int by, const Region& whole) {
  return common({r.x0 - by, r.y0 - by, r.x1 + by, r.y1 + by}, whole);
}
/// The pixels of the next coarser level that a region (not left of or above 0) touches.
inline Region halved(const Region& r) { return {r.x0 / 2, r.y0 / 2, (r.x1 + 1) / 2, (r.y1 + 1) / 2}; }
inline Region doubled(const Region& r) { return {2 * r.x0, 2 * r.y0, 2 * r.x1, 2 * r.y1}; }

/// Something for every pixel of a region.
template <class T>
struct Grid {
  Region region;
  std::vector<T> values;

  Grid() = default;
  explicit Grid(const Region& r, T fill = T{})
      : region(r), values(static_cast<std::size_t>(r.width()) * static_cast<std::size_t>(r.height()), fill) {}
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - region.y0) * static_cast<std::size_t>(region.width()) +
           static_cast<std::size_t>(x - region.x0);
  }
  T& at(int x, int y) { return values[index(x, y)]; }
  const T& at(int x, int y) const { return values[index(x, y)]; }
  /// That of the nearest pixel there is.
  const T& nearest(int x, int y) const {
    return at(std::clamp(x, region.x0, region.x1 - 1), std::clamp(y, region.y0, region.y1 - 1));
  }
};

/// Red, green, blue as files store them (encoded, not linear), 0 to 255, not rounded.
using Color = std::array<float, 3>;
using ColorGrid = Grid<Color>;

/// A picture of 3 or 4 channels (opacity is left out) as a grid from (0, 0), and a grid rounded and clamped.
ColorGrid to_colors(const Image& picture);
Image to_picture(const ColorGrid& colors);

/// Means of 2 x 2 pixels; the region's corners are even.
ColorGrid halved(const ColorGrid& fine);

/// A level twice as fine on `region`, whose 2 x 2 means are exactly the coarse pixels: interpolation of means
/// by polynomials of the fourth degree (D. Donoho, "Smooth wavelet decompositions with blocky coefficient
/// kernels", 1993), along x and y. Looks two coarse pixels further than halved(region); at the grid's border
/// the border's pixel.
ColorGrid refined(const ColorGrid& coarse, const Region& region);

}  // namespace floatstage::detail
