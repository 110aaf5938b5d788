#include "pipeline/take_outlines.h"

#include <algorithm>

#include "core/image.h"

namespace floatstage::pipeline {
namespace {

constexpr int kReach = 2;  // px to each side

/// The smallest, or largest, of the values around each pixel, first along rows, then along columns.
Image spread(const Image& from, bool grow) {
  const auto better = [&](std::uint8_t a, std::uint8_t b) { return grow ? std::max(a, b) : std::min(a, b); };
  Image rows = from, out = from;
  for (int y = 0; y < from.height; ++y)
    for (int x = 0; x < from.width; ++x)
      for (int u = std::max(0, x - kReach); u <= std::min(from.width - 1, x + kReach); ++u)
        *rows.at(x, y) = better(*rows.at(x, y), *from.at(u, y));
  for (int y = 0; y < from.height; ++y)
    for (int x = 0; x < from.width; ++x) {
      *out.at(x, y) = *rows.at(x, y);
      for (int v = std::max(0, y - kReach); v <= std::min(from.height - 1, y + kReach); ++v)
        *out.at(x, y) = better(*out.at(x, y), *rows.at(x, v));
    }
  return out;
}

}  // namespace

Matte without_strands(const Matte& matte) {
  if (matte.empty()) return matte;
  return make_matte(matte.source, spread(spread(to_image(matte), false), true));
}

}  // namespace floatstage::pipeline
