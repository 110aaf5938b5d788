#include "studio/node/foreground_tile.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace floatstage::studio {
namespace {

constexpr int kBorder = 4;  // px: what a spline and the edge of the enlarged matte reach

/// For each pixel of a line of the photograph: the two small pixels around it, and the share of the second in
/// 256ths.
struct Tap {
  int low, high, share;
};

std::vector<Tap> taps(int first, int count, int factor, int small) {
  std::vector<Tap> line(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double at = (first + i + 0.5) / factor - 0.5, floor = std::floor(at);
    const int low = static_cast<int>(floor);
    line[static_cast<std::size_t>(i)] = {std::clamp(low, 0, small - 1), std::clamp(low + 1, 0, small - 1),
                                         static_cast<int>(std::lround((at - floor) * 256))};
  }
  return line;
}

bool any(const std::uint8_t* row, int from, int to) {
  return std::any_of(row + from, row + to, [](std::uint8_t v) { return v != 0; });
}

}  // namespace

PixelBox subject_box(const Matte& small, int factor, int width, int height) {
  int top = 0, bottom = small.height;
  while (top < bottom && !any(small.row(top), 0, small.width)) ++top;
  while (bottom > top && !any(small.row(bottom - 1), 0, small.width)) --bottom;
  if (top == bottom) return {};
  int left = small.width, right = 0;
  for (int y = top; y < bottom; ++y) {
    const std::uint8_t* row = small.row(y);
    for (int x = 0; x < left; ++x)
      if (row[x] != 0) left = x;
    for (int x = small.width; x > right; --x)
      if (row[x - 1] != 0) right = x;
  }
  const int x0 = std::max(left * factor - kBorder - factor, 0),
            y0 = std::max(top * factor - kBorder - factor, 0);
  const int x1 = std::min(right * factor + kBorder + factor, width),
            y1 = std::min(bottom * factor + kBorder + factor, height);
  return {x0, y0, x1 - x0, y1 - y0};
}

Image enlarged(const Matte& small, int factor, const PixelBox& box) {
  Image out(box.width, box.height, 1);
  if (factor == 1) {
    for (int y = 0; y < box.height; ++y) std::copy_n(small.row(box.y + y) + box.x, box.width, out.at(0, y));
    return out;
  }
  const std::vector<Tap> across = taps(box.x, box.width, factor, small.width),
                         down = taps(box.y, box.height, factor, small.height);
  std::vector<int> line(static_cast<std::size_t>(small.width));  // of small pixels, between two rows; 256ths
  const int from = across.empty() ? 0 : across.front().low, to = across.empty() ? 0 : across.back().high + 1;
  for (int y = 0; y < box.height; ++y) {
    const Tap& t = down[static_cast<std::size_t>(y)];
    const std::uint8_t *low = small.row(t.low), *high = small.row(t.high);
    for (int x = from; x < to; ++x)
      line[static_cast<std::size_t>(x)] = low[x] * (256 - t.share) + high[x] * t.share;
    std::uint8_t* row = out.at(0, y);
    for (const Tap& a : across) {
      const int l = line[static_cast<std::size_t>(a.low)], h = line[static_cast<std::size_t>(a.high)];
      *row++ = static_cast<std::uint8_t>((l * (256 - a.share) + h * a.share + (1 << 15)) >> 16);
    }
  }
  return out;
}

}  // namespace floatstage::studio
