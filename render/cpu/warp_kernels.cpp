#include "render/cpu/warp_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/warp_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::cpu::HWY_NAMESPACE {

constexpr int kInversions = 4;
constexpr float kLeastAlpha = 0.5F;

// Both vectors of two neighbours in one: u v u v.
typedef float Quad __attribute__((vector_size(16)));

HWY_INLINE Quad load(const float* from) {
  Quad q;
  std::memcpy(&q, from, sizeof q);
  return q;
}

void InvertWarps(const WarpFields& fields, const WarpedRow& row) {
  const float inverse = 1 / fields.shrink;
  const float last_x = static_cast<float>(fields.width - 1), last_y = static_cast<float>(fields.height - 1);
  const auto step = static_cast<std::ptrdiff_t>(2) * fields.width;
  for (int i = 0; i < row.count; ++i) {
    row.from_x[i] = row.x[i];
    row.from_y[i] = row.y;
  }
  for (int k = 0; k < kInversions; ++k)
    for (int i = 0; i < row.count; ++i) {
      const float x = std::min(std::max(row.from_x[i] * inverse - 0.5F, 0.F), last_x);
      const float y = std::min(std::max(row.from_y[i] * inverse - 0.5F, 0.F), last_y);
      const int x0 = std::min(static_cast<int>(x), fields.width - 2);
      const int y0 = std::min(static_cast<int>(y), fields.height - 2);
      const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
      const std::ptrdiff_t at = y0 * step + 2 * x0;
      Quad top = {}, bottom = {};
      for (int f = 0; f < fields.count; ++f) {
        const auto n = static_cast<std::size_t>(f);
        const float pull = fields.pulls[n][i];
        top += pull * load(fields.uv[n] + at);
        bottom += pull * load(fields.uv[n] + at + step);
      }
      const Quad both = top + fy * (bottom - top);
      row.from_x[i] = row.x[i] - fields.shrink * (both[0] + fx * (both[2] - both[0]));
      row.from_y[i] = row.y - fields.shrink * (both[1] + fx * (both[3] - both[1]));
    }
}

struct Taps {
  std::ptrdiff_t at[4];
  float weight[4];
};

HWY_INLINE Taps taps(const WarpSource& s, float x, float y) {
  // Far outside is as good as one pixel outside; and no number is somewhere.
  x = std::min(std::max(x - 0.5F, -1.F), static_cast<float>(s.width));
  y = std::min(std::max(y - 0.5F, -1.F), static_cast<float>(s.height));
  const int low_x = static_cast<int>(std::floor(x)), low_y = static_cast<int>(std::floor(y));
  const float fx = x - static_cast<float>(low_x), fy = y - static_cast<float>(low_y);
  const int x0 = std::min(std::max(low_x, 0), s.width - 1), x1 = std::min(low_x + 1, s.width - 1);
  const int y0 = std::min(std::max(low_y, 0), s.height - 1), y1 = std::min(low_y + 1, s.height - 1);
  const std::ptrdiff_t top = static_cast<std::ptrdiff_t>(y0) * s.width,
                       bottom = static_cast<std::ptrdiff_t>(y1) * s.width;
  return {{top + x0, top + x1, bottom + x0, bottom + x1},
          {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

HWY_INLINE float mixed(const float* plane, const Taps& t) {
  return t.weight[0] * plane[t.at[0]] + t.weight[1] * plane[t.at[1]] + t.weight[2] * plane[t.at[2]] +
         t.weight[3] * plane[t.at[3]];
}

void LookUp(const WarpSource& s, const WarpedRow& row) {
  for (int i = 0; i < row.count; ++i) {
    const Taps t = taps(s, row.from_x[i], row.from_y[i]);
    const int own = s.own[t.at[0]] & s.own[t.at[1]] & s.own[t.at[2]] & s.own[t.at[3]];
    const float a = s.inverse_z[t.at[0]], b = s.inverse_z[t.at[1]], c = s.inverse_z[t.at[2]],
                d = s.inverse_z[t.at[3]];
    const float least = std::min(std::min(a, b), std::min(c, d)),
                most = std::max(std::max(a, b), std::max(c, d));
    const bool connected = most - least < s.tolerance * least * most;  // z's range, without dividing
    row.direct[i] = (own >> s.slot & 1) != 0 && connected ? 1 : 0;
    row.inverse_z[i] = t.weight[0] * a + t.weight[1] * b + t.weight[2] * c + t.weight[3] * d;
    row.seen[i] = mixed(s.soft, t);
  }
}

void BorrowColors(const WarpSource& s, const WarpedRow& row, float* rgba) {
  for (int i = 0; i < row.count; ++i) {
    if (row.direct[i] != 0) continue;
    Taps t = taps(s, row.from_x[i], row.from_y[i]);
    float* out = rgba + 4 * i;
    float sum[4] = {0, 0, 0, 0};
    for (int k = 0; k < 4; ++k) {
      if (s.inverse_z[t.at[k]] <= 0) continue;
      std::uint8_t c[4];
      std::memcpy(c, s.image + t.at[k], 4);
      for (int channel = 0; channel < 3; ++channel)
        sum[channel] += t.weight[k] * static_cast<float>(c[channel]);
      sum[3] += t.weight[k];
    }
    if (sum[3] >= kLeastAlpha) {
      for (int channel = 0; channel < 3; ++channel) out[channel] = sum[channel] / sum[3];
    } else {
      row.from_x[i] = row.x[i];
      row.from_y[i] = row.y;
      t = taps(s, row.x[i], row.y);
      std::uint8_t c[4];
      std::memcpy(c, s.image + t.at[0], 4);
      for (int channel = 0; channel < 3; ++channel) out[channel] = static_cast<float>(c[channel]);
      row.seen[i] = s.soft[t.at[0]];
    }
  }
}

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render::cpu {

HWY_EXPORT(InvertWarps);
HWY_EXPORT(LookUp);
HWY_EXPORT(BorrowColors);

void invert_warps(const WarpFields& fields, const WarpedRow& row) {
  HWY_DYNAMIC_DISPATCH(InvertWarps)(fields, row);
}

void look_up(const WarpSource& source, const WarpedRow& row) { HWY_DYNAMIC_DISPATCH(LookUp)(source, row); }

void borrow_colors(const WarpSource& source, const WarpedRow& row, float* rgba) {
  HWY_DYNAMIC_DISPATCH(BorrowColors)(source, row, rgba);
}

}  // namespace floatstage::render::cpu
#endif
