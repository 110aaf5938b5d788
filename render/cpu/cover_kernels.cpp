#include "render/cpu/cover_kernels.h"

#include <algorithm>
#include <utility>

namespace floatstage::render::cpu {
namespace {

constexpr int kGrid = 256;  // steps a pixel

/// Not negative inside, at a place of the grid; by the top-left rule.
struct Side {
  std::int64_t a, b, c;
  Side(const ScreenVertex& p, const ScreenVertex& q) : a(p.y - q.y), b(q.x - p.x), c(-(a * p.x + b * p.y)) {
    if (!(a > 0 || (a == 0 && b > 0))) --c;
  }
  std::int64_t at(std::int64_t x, std::int64_t y) const { return a * x + b * y + c; }
};

/// The first and the last pixel whose samples may lie in [low, high].
int first_of(std::int32_t low) { return (low - kGrid / 2 + kGrid - 1) >> 8; }
int last_of(std::int32_t high) { return (high + kGrid / 2) >> 8; }

void cover(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, const CoverRows& to) {
  const int top = std::max(first_of(std::min({a.y, b.y, c.y})), to.first),
            bottom = std::min(last_of(std::max({a.y, b.y, c.y})), to.last - 1),
            left = std::max(first_of(std::min({a.x, b.x, c.x})), 0),
            right = std::min(last_of(std::max({a.x, b.x, c.x})), to.width - 1);
  const Side ab(a, b), bc(b, c), ca(c, a);
  for (int y = top; y <= bottom; ++y) {
    const std::size_t line = static_cast<std::size_t>(y) * static_cast<std::size_t>(to.width);
    for (int x = left; x <= right; ++x) {
      const std::size_t i = line + static_cast<std::size_t>(x);
      if (to.wanted[i] == 0) continue;
      for (std::size_t s = 0; s < kSamples.size(); ++s) {
        const std::int64_t u = std::int64_t{x} * kGrid + kSamples[s][0],
                           v = std::int64_t{y} * kGrid + kSamples[s][1];
        if ((ab.at(u, v) | bc.at(u, v) | ca.at(u, v)) >= 0)
          to.covered[i] = static_cast<std::uint8_t>(to.covered[i] | 1 << s);
      }
    }
  }
}

}  // namespace

void cover_triangles(const ScreenVertex* vertices, const std::uint32_t* corners, std::uint32_t count,
                     bool cull, const CoverRows& to) {
  for (std::uint32_t t = 0; t < count; ++t, corners += 3) {
    const ScreenVertex& a = vertices[corners[0]];
    const ScreenVertex *b = vertices + corners[1], *c = vertices + corners[2];
    const std::int64_t area =
        std::int64_t{b->x - a.x} * (c->y - a.y) - std::int64_t{c->x - a.x} * (b->y - a.y);
    if (area == 0 || (cull && area > 0)) continue;
    if (area < 0) std::swap(b, c);
    cover(a, *b, *c, to);
  }
}

}  // namespace floatstage::render::cpu
