#include "render/cpu/raster_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/raster_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::cpu::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int kGrid = 256;    // steps a pixel
constexpr int kNarrow = 8;    // px: triangles up to here are drawn a row at a time
constexpr int kFewRows = 24;  // likewise, so that 32 bits hold their edges
using D = hn::CappedTag<float, kNarrow>;
using DI = hn::RebindToSigned<D>;
using DU = hn::RebindToUnsigned<D>;

HWY_INLINE std::int32_t first_sample(std::int32_t at) { return (at + kGrid - 1) >> 8; }
HWY_INLINE std::int32_t last_sample(std::int32_t at) { return at >> 8; }

/// a x + b y + c >= 0 inside, on the sample grid; c carries the top-left rule.
template <class T>
struct Edge {
  T a, b, c;
  T at(int x, int y) const { return a * x + b * y + c; }
};

/// Of p → q, with positions from (x, y): a sample on an edge belongs to the triangle where it is a left or a
/// top one.
template <class T>
HWY_INLINE Edge<T> edge(const ScreenVertex& p, const ScreenVertex& q, std::int32_t x, std::int32_t y) {
  const T a = p.y - q.y, b = q.x - p.x;
  const bool left_or_top = a > 0 || (a == 0 && b > 0);
  return {a * kGrid, b * kGrid, -(a * (p.x - x) + b * (p.y - y)) - (left_or_top ? 0 : 1)};
}

/// The pixels that a triangle with a turn of `area` > 0 may cover, and how 1/z follows from its edges.
struct Setup {
  int left, right, low, high;
  float z, from_b, from_c;
};

HWY_INLINE void draw_narrow(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c,
                            const Setup& s, std::uint32_t index, const RasterRows& to) {
  const D d;
  const DI di;
  const DU du;
  const std::int32_t x = s.left * kGrid, y = s.low * kGrid;
  const Edge<std::int32_t> ab = edge<std::int32_t>(a, b, x, y), bc = edge<std::int32_t>(b, c, x, y),
                           ca = edge<std::int32_t>(c, a, x, y);
  std::size_t row =
      static_cast<std::size_t>(s.low) * static_cast<std::size_t>(to.width) + static_cast<std::size_t>(s.left);
  for (int line = 0; line <= s.high - s.low; ++line, row += static_cast<std::size_t>(to.width))
    for (int first = 0; first <= s.right - s.left; first += static_cast<int>(hn::Lanes(d))) {
      const auto column = hn::Iota(di, first);
      auto along = [&](const Edge<std::int32_t>& e) HWY_ATTR {
        return hn::Add(hn::Mul(column, hn::Set(di, e.a)), hn::Set(di, e.at(0, line)));
      };
      const auto in_ab = along(ab), in_bc = along(bc), in_ca = along(ca);
      const auto inside =
          hn::Not(hn::RebindMask(d, hn::Lt(hn::Or(hn::Or(in_ab, in_bc), in_ca), hn::Zero(di))));
      const auto z = hn::MulAdd(hn::ConvertTo(d, in_ca), hn::Set(d, s.from_b),
                                hn::MulAdd(hn::ConvertTo(d, in_ab), hn::Set(d, s.from_c), hn::Set(d, s.z)));
      float* depth = to.inverse_z + row + first;
      const auto there = hn::LoadU(d, depth);
      const auto nearer = hn::And(inside, hn::Gt(z, there));
      hn::StoreU(hn::IfThenElse(nearer, z, there), d, depth);
      if (to.triangle == nullptr) continue;
      std::uint32_t* ids = to.triangle + row + first;
      hn::StoreU(hn::IfThenElse(hn::RebindMask(du, nearer), hn::Set(du, index), hn::LoadU(du, ids)), du, ids);
    }
}

void draw_wide(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, const Setup& s,
               std::uint32_t index, const RasterRows& to) {
  const Edge<std::int64_t> ab = edge<std::int64_t>(a, b, 0, 0), bc = edge<std::int64_t>(b, c, 0, 0),
                           ca = edge<std::int64_t>(c, a, 0, 0);
  for (int y = s.low; y <= s.high; ++y) {
    int x0 = s.left, x1 = s.right;
    for (const Edge<std::int64_t>& e : {ab, bc, ca}) {  // the row's part inside; doubles hold these integers
      const std::int64_t rest = e.b * y + e.c;
      const double ratio = e.a == 0 ? 0 : -static_cast<double>(rest) / static_cast<double>(e.a);
      if (e.a > 0)
        x0 = std::max(x0, static_cast<int>(std::min(std::max(std::ceil(ratio), 0.0), 1e9)));
      else if (e.a < 0)
        x1 = std::min(x1, static_cast<int>(std::min(std::max(std::floor(ratio), -1.0), 1e9)));
      else if (rest < 0)
        x1 = -1;
    }
    std::int64_t in_ab = ab.at(x0, y), in_bc = bc.at(x0, y), in_ca = ca.at(x0, y);
    std::size_t at =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(to.width) + static_cast<std::size_t>(x0);
    for (int x = x0; x <= x1; ++x, ++at, in_ab += ab.a, in_bc += bc.a, in_ca += ca.a) {
      if ((in_ab | in_bc | in_ca) < 0) continue;
      const float z = s.z + static_cast<float>(in_ca) * s.from_b + static_cast<float>(in_ab) * s.from_c;
      if (z <= to.inverse_z[at]) continue;
      to.inverse_z[at] = z;
      if (to.triangle != nullptr) to.triangle[at] = index;
    }
  }
}

void DrawTriangles(const ScreenVertex* vertices, const std::uint32_t* corners, std::uint32_t count,
                   std::uint32_t first_index, bool cull, const RasterRows& to) {
  for (std::uint32_t t = 0; t < count; ++t, corners += 3) {
    const ScreenVertex& a = vertices[corners[0]];
    const ScreenVertex *b = vertices + corners[1], *c = vertices + corners[2];
    std::int64_t area = static_cast<std::int64_t>(b->x - a.x) * (c->y - a.y) -
                        static_cast<std::int64_t>(c->x - a.x) * (b->y - a.y);
    if (area == 0 || (cull && area > 0)) continue;
    Setup s;
    s.low = std::max(first_sample(std::min(std::min(a.y, b->y), c->y)), to.first);
    s.high = std::min(last_sample(std::max(std::max(a.y, b->y), c->y)), to.last - 1);
    if (s.low > s.high) continue;
    s.left = std::max(first_sample(std::min(std::min(a.x, b->x), c->x)), 0);
    s.right = std::min(last_sample(std::max(std::max(a.x, b->x), c->x)), to.width - 1);
    if (s.left > s.right) continue;
    if (area < 0) {  // y points down: counter-clockwise seen from outside
      std::swap(b, c);
      area = -area;
    }
    const float share = 1 / static_cast<float>(area);
    s.z = a.inverse_z;
    s.from_b = (b->inverse_z - a.inverse_z) * share;
    s.from_c = (c->inverse_z - a.inverse_z) * share;
    // What a row's vectors read beyond the triangle lies in its row.
    constexpr std::int64_t kSmall = std::int64_t{kNarrow} * kFewRows * kGrid * kGrid;
    const bool narrow = s.right - s.left < kNarrow && s.high - s.low < kFewRows &&
                        s.left + kNarrow <= to.width && area < kSmall &&
                        std::abs(a.x - s.left * kGrid) < kGrid * kFewRows &&
                        std::abs(a.y - s.low * kGrid) < kGrid * kFewRows &&
                        std::abs(b->x - a.x) < kGrid * kFewRows && std::abs(c->x - a.x) < kGrid * kFewRows &&
                        std::abs(b->y - a.y) < kGrid * kFewRows && std::abs(c->y - a.y) < kGrid * kFewRows;
    if (narrow)
      draw_narrow(a, *b, *c, s, first_index + t, to);
    else
      draw_wide(a, *b, *c, s, first_index + t, to);
  }
}

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render::cpu {

HWY_EXPORT(DrawTriangles);

void draw_triangles(const ScreenVertex* vertices, const std::uint32_t* corners, std::uint32_t count,
                    std::uint32_t first_index, bool cull, const RasterRows& to) {
  HWY_DYNAMIC_DISPATCH(DrawTriangles)(vertices, corners, count, first_index, cull, to);
}

}  // namespace floatstage::render::cpu
#endif
