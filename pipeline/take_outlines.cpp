#include "pipeline/take_outlines.h"

#include <algorithm>

#include "core/image.h"

namespace floatstage::pipeline {
namespace {

constexpr int kReach = 2;  // px to each side

/// Each of `to` becomes the better of itself and what is at its place in `from`.
template <class Better>
void take_better(const std::uint8_t* from, std::uint8_t* to, int count, const Better& better) {
  for (int i = 0; i < count; ++i) to[i] = better(to[i], from[i]);
}

/// The better of the values around each pixel, first along rows, then along columns.
template <class Better>
Image spread(const Image& from, const Better& better) {
  Image rows = from;
  for (int y = 0; y < from.height; ++y)
    for (int by = 1; by <= std::min(kReach, from.width - 1); ++by) {
      take_better(from.at(by, y), rows.at(0, y), from.width - by, better);
      take_better(from.at(0, y), rows.at(by, y), from.width - by, better);
    }
  Image out = rows;
  for (int y = 0; y < from.height; ++y)
    for (int v = std::max(0, y - kReach); v <= std::min(from.height - 1, y + kReach); ++v)
      take_better(rows.at(0, v), out.at(0, y), from.width, better);
  return out;
}

}  // namespace

Matte without_strands(const Matte& matte) {
  if (matte.empty()) return matte;
  const Image opened = spread(to_image(matte), [](std::uint8_t a, std::uint8_t b) { return std::min(a, b); });
  return make_matte(matte.source,
                    spread(opened, [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); }));
}

}  // namespace floatstage::pipeline
