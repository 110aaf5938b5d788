// Plain loops over rows, which the compiler makes vectors of: one unknown a pixel instead of two (the energy
// of Brox et al. 2004, normalised as in Zimmer et al. 2009, along given directions).
#include "render/flow/depth_kernels.h"

#include <cmath>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/flow/depth_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::HWY_NAMESPACE {

HWY_INLINE void shift_half(SplitSpan span, const float* e, const float* dx, const float* dy,
                           float* HWY_RESTRICT x, float* HWY_RESTRICT y) {
  for (int i = span.begin; i < span.end; ++i) {
    x[i] = e[i] * dx[i];
    y[i] = e[i] * dy[i];
  }
}

void DepthShift(SplitSpan span, ConstSplitRow e, const DirectionRow& direction, SplitRow x, SplitRow y) {
  shift_half(span, e.even, direction.x.even, direction.y.even, x.even, y.even);
  shift_half(span, e.odd, direction.x.odd, direction.y.odd, x.odd, y.odd);
}

HWY_INLINE void pair_half(SplitSpan span, float share, const float* v0, const float* v1, const float* w0,
                          const float* w1, float* HWY_RESTRICT mean, float* HWY_RESTRICT difference,
                          float* HWY_RESTRICT weight) {
  for (int i = span.begin; i < span.end; ++i) {
    mean[i] = 0.5F * (v0[i] + v1[i]);
    difference[i] = v1[i] - v0[i];
    weight[i] = share * (w0[i] * w1[i]);
  }
}

void DepthPair(SplitSpan span, float share, const ReadRow& first, const ReadRow& second, SplitRow mean,
               SplitRow difference, SplitRow weight) {
  pair_half(span, share, first.value.even, second.value.even, first.weight.even, second.weight.even,
            mean.even, difference.even, weight.even);
  pair_half(span, share, first.value.odd, second.value.odd, first.weight.odd, second.weight.odd, mean.odd,
            difference.odd, weight.odd);
}

// One parity of a row and what lies around it: left and right are of the other parity.
struct Around {
  const float *here, *left, *right, *above, *below;
};
HWY_INLINE Around around(const ThreeRows& rows, int parity) {
  if (parity == 0)
    return {rows.here.even, rows.here.odd - 1, rows.here.odd, rows.above.even, rows.below.even};
  return {rows.here.odd, rows.here.even, rows.here.even + 1, rows.above.odd, rows.below.odd};
}

HWY_INLINE void terms_half(SplitSpan span, int parity, const FlowEnergy& energy, const DepthTerms& t,
                           float* HWY_RESTRICT a, float* HWY_RESTRICT b) {
  const Around gx = around(t.dx, parity), gy = around(t.dy, parity), d = around(t.difference, parity);
  const bool even = parity == 0;
  const float *weight = even ? t.weight.even : t.weight.odd, *e = even ? t.e.even : t.e.odd;
  const float *x0 = even ? t.first.x.even : t.first.x.odd, *y0 = even ? t.first.y.even : t.first.y.odd;
  const float *x1 = even ? t.second.x.even : t.second.x.odd, *y1 = even ? t.second.y.even : t.second.y.odd;
  const float noise2 = energy.noise2, epsilon2 = energy.data_epsilon2, gamma = energy.gradient_weight;
  for (int i = span.begin; i < span.end; ++i) {
    const float ax = x1[i] - x0[i], ay = y1[i] - y0[i];
    const float xx = 0.5F * (gx.right[i] - gx.left[i]), xy = 0.5F * (gx.below[i] - gx.above[i]),
                yy = 0.5F * (gy.below[i] - gy.above[i]);
    const float xt = 0.5F * (d.right[i] - d.left[i]), yt = 0.5F * (d.below[i] - d.above[i]);
    // How difference and its gradient change with e.
    const float r = gx.here[i] * ax + gy.here[i] * ay, rx = xx * ax + xy * ay, ry = xy * ax + yy * ay;
    const float theta = 1.F / ((gx.here[i] * gx.here[i] + gy.here[i] * gy.here[i]) + noise2);
    const float theta_x = 1.F / ((xx * xx + xy * xy) + noise2);
    const float theta_y = 1.F / ((xy * xy + yy * yy) + noise2);
    const float bright = noise2 * (theta * (d.here[i] * d.here[i]));
    const float grad = noise2 * (theta_x * (xt * xt) + theta_y * (yt * yt));
    const float scaled = weight[i] * noise2;
    const float p = (scaled * theta) / std::sqrt(bright + epsilon2);
    const float g = (scaled * gamma) / std::sqrt(grad + epsilon2);
    const float px = g * theta_x, py = g * theta_y;
    const float own = p * (r * r) + (px * (rx * rx) + py * (ry * ry));
    const float c = p * (r * d.here[i]) + (px * (rx * xt) + py * (ry * yt));
    a[i] += own;
    b[i] += own * e[i] - c;
  }
}

void DepthTermsOf(SplitSpan span, const FlowEnergy& energy, const DepthTerms& terms, SplitRow a, SplitRow b) {
  terms_half(span, 0, energy, terms, a.even, b.even);
  terms_half(span, 1, energy, terms, a.odd, b.odd);
}

HWY_INLINE void invert_half(SplitSpan span, float omega, const float* right, const float* left,
                            const float* down, const float* up, float* HWY_RESTRICT a) {
  constexpr float kLeast = 1e-12F;
  for (int i = span.begin; i < span.end; ++i) {
    const float all = a[i] + ((right[i] + left[i]) + (down[i] + up[i]));
    a[i] = all > kLeast ? omega / all : 0.F;
  }
}

void DepthInvert(SplitSpan span, float omega, ConstSplitRow right, ConstSplitRow down,
                 ConstSplitRow down_above, SplitRow a) {
  invert_half(span, omega, right.even, right.odd - 1, down.even, down_above.even, a.even);
  invert_half(span, omega, right.odd, right.even, down.odd, down_above.odd, a.odd);
}

HWY_INLINE void relax_half(SplitSpan span, float omega, const float* inverse, const float* b,
                           const float* right, const float* left, const float* down, const float* up,
                           const Around& e, float* HWY_RESTRICT out) {
  const float keep = 1.F - omega;
  for (int i = span.begin; i < span.end; ++i) {
    const float sum =
        b[i] + ((right[i] * e.right[i] + left[i] * e.left[i]) + (down[i] * e.below[i] + up[i] * e.above[i]));
    out[i] = keep * out[i] + inverse[i] * sum;
  }
}

void DepthRelax(SplitSpan span, int parity, float omega, ConstSplitRow inverse, ConstSplitRow b,
                ConstSplitRow right, ConstSplitRow down, ConstSplitRow down_above, const ThreeRows& e,
                SplitRow out) {
  if (parity == 0)
    relax_half(span, omega, inverse.even, b.even, right.even, right.odd - 1, down.even, down_above.even,
               around(e, 0), out.even);
  else
    relax_half(span, omega, inverse.odd, b.odd, right.odd, right.even, down.odd, down_above.odd, around(e, 1),
               out.odd);
}

}  // namespace floatstage::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render {

HWY_EXPORT(DepthShift);
HWY_EXPORT(DepthPair);
HWY_EXPORT(DepthTermsOf);
HWY_EXPORT(DepthInvert);
HWY_EXPORT(DepthRelax);

void depth_shift(SplitSpan span, ConstSplitRow e, const DirectionRow& direction, SplitRow x, SplitRow y) {
  HWY_DYNAMIC_DISPATCH(DepthShift)(span, e, direction, x, y);
}

void depth_pair(SplitSpan span, float share, const ReadRow& first, const ReadRow& second, SplitRow mean,
                SplitRow difference, SplitRow weight) {
  HWY_DYNAMIC_DISPATCH(DepthPair)(span, share, first, second, mean, difference, weight);
}

void depth_terms(SplitSpan span, const FlowEnergy& energy, const DepthTerms& terms, SplitRow a, SplitRow b) {
  HWY_DYNAMIC_DISPATCH(DepthTermsOf)(span, energy, terms, a, b);
}

void depth_invert(SplitSpan span, float omega, ConstSplitRow right, ConstSplitRow down,
                  ConstSplitRow down_above, SplitRow a) {
  HWY_DYNAMIC_DISPATCH(DepthInvert)(span, omega, right, down, down_above, a);
}

void depth_relax(SplitSpan span, int parity, float omega, ConstSplitRow inverse, ConstSplitRow b,
                 ConstSplitRow right, ConstSplitRow down, ConstSplitRow down_above, const ThreeRows& e,
                 SplitRow out) {
  HWY_DYNAMIC_DISPATCH(DepthRelax)(span, parity, omega, inverse, b, right, down, down_above, e, out);
}

}  // namespace floatstage::render
#endif
