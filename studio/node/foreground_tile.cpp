#include "studio/node/foreground_tile.h"

#include <algorithm>
#include <cmath>

namespace floatstage::studio {
namespace {

constexpr int kBorder = 4;  // px: what a spline and the edge of the enlarged matte reach

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

void MatteEnlarger::find_taps(int first, int count, int factor, int small, std::vector<Tap>& line) {
  line.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double at = (first + i + 0.5) / factor - 0.5, floor = std::floor(at);
    const int low = static_cast<int>(floor);
    line[static_cast<std::size_t>(i)] = {std::clamp(low, 0, small - 1), std::clamp(low + 1, 0, small - 1),
                                         static_cast<int>(std::lround((at - floor) * 256))};
  }
}

void MatteEnlarger::enlarge(const Matte& small, int factor, const PixelBox& box, Image& out) {
  out.resize(box.width, box.height, 1);
  if (factor == 1) {
    for (int y = 0; y < box.height; ++y) std::copy_n(small.row(box.y + y) + box.x, box.width, out.at(0, y));
    return;
  }
  find_taps(box.x, box.width, factor, small.width, across_);
  find_taps(box.y, box.height, factor, small.height, down_);
  line_.resize(static_cast<std::size_t>(small.width));
  const int from = across_.empty() ? 0 : across_.front().low,
            to = across_.empty() ? 0 : across_.back().high + 1;
  for (int y = 0; y < box.height; ++y) {
    const Tap& t = down_[static_cast<std::size_t>(y)];
    const std::uint8_t *low = small.row(t.low), *high = small.row(t.high);
    for (int x = from; x < to; ++x)
      line_[static_cast<std::size_t>(x)] = low[x] * (256 - t.share) + high[x] * t.share;
    std::uint8_t* row = out.at(0, y);
    for (const Tap& a : across_) {
      const int l = line_[static_cast<std::size_t>(a.low)], h = line_[static_cast<std::size_t>(a.high)];
      *row++ = static_cast<std::uint8_t>((l * (256 - a.share) + h * a.share + (1 << 15)) >> 16);
    }
  }
}

}  // namespace floatstage::studio
