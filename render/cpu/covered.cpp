#include "render/cpu/covered.h"

#include <algorithm>

namespace floatstage::render::cpu {

void Covered::find(int width, int height, const float* plane) {
  spans.clear();
  rows.clear();
  std::size_t list = 0;
  for (int y = 0; y < height; ++y) {
    const float* row = plane + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    Row here{spans.size(), spans.size(), list, 0};
    for (int at = 0; at < width;) {
      while (at < width && row[at] <= 0) ++at;
      const int begin = at;
      while (at < width && row[at] > 0) ++at;
      if (at == begin) break;
      spans.push_back({begin, at, list + static_cast<std::size_t>(here.count)});
      here.count += at - begin;
    }
    here.last_span = spans.size();
    rows.push_back(here);
    list += static_cast<std::size_t>((here.count + kAlign - 1) / kAlign * kAlign);
  }
  padded = list;
  if (x.size() < padded) {
    x.resize(padded);
    inverse_z.resize(padded);
  }
  for (const Row& row : rows) {
    for (std::size_t s = row.first_span; s < row.last_span; ++s) {
      const Span& span = spans[s];
      const auto y = static_cast<std::size_t>(&row - rows.data());
      std::copy(plane + y * static_cast<std::size_t>(width) + static_cast<std::size_t>(span.begin),
                plane + y * static_cast<std::size_t>(width) + static_cast<std::size_t>(span.end),
                inverse_z.begin() + static_cast<std::ptrdiff_t>(span.list));
      for (int i = span.begin; i < span.end; ++i)
        x[span.list + static_cast<std::size_t>(i - span.begin)] = static_cast<float>(i) + 0.5F;
    }
    // The padding holds the row's last pixel again: numbers that are good, and stay unread.
    const std::size_t end = row.list + static_cast<std::size_t>(row.count),
                      full = row.list + static_cast<std::size_t>((row.count + kAlign - 1) / kAlign * kAlign);
    for (std::size_t i = end; i < full; ++i) {
      x[i] = x[end - 1];
      inverse_z[i] = inverse_z[end - 1];
    }
  }
}

}  // namespace floatstage::render::cpu
