// Plain loops over rows, which the compiler makes vectors of, but where there are roots: one unknown a pixel
// instead of two (the energy of Brox et al. 2004, normalised as in Zimmer et al. 2009, along given
// directions).
#include "render/flow/depth_kernels.h"

#include <algorithm>
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

constexpr float kLeastUsual = 1e-6F;  // images that are alike to the bit are believed

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

// Roots are written as vectors: compilers make none of std::sqrt, which may have to set errno.
namespace hn = hwy::HWY_NAMESPACE;
using F = HWY_CAPPED(float, kSplitBlock);
using VF = hn::Vec<F>;

HWY_INLINE VF load(const float* at) { return hn::LoadU(F(), at); }
HWY_INLINE VF mul(VF a, VF b) { return hn::Mul(a, b); }
HWY_INLINE VF add(VF a, VF b) { return hn::Add(a, b); }
HWY_INLINE VF half_difference(const float* a, const float* b) {
  return mul(hn::Set(F(), 0.5F), hn::Sub(load(a), load(b)));
}

HWY_INLINE void terms_half(SplitSpan span, int parity, const FlowEnergy& energy, const DepthTerms& t,
                           float* HWY_RESTRICT a, float* HWY_RESTRICT b) {
  const Around gx = around(t.dx, parity), gy = around(t.dy, parity), d = around(t.difference, parity);
  const bool even = parity == 0;
  const float *weight = even ? t.weight.even : t.weight.odd, *e = even ? t.e.even : t.e.odd;
  const float *x0 = even ? t.first.x.even : t.first.x.odd, *y0 = even ? t.first.y.even : t.first.y.odd;
  const float *x1 = even ? t.second.x.even : t.second.x.odd, *y1 = even ? t.second.y.even : t.second.y.odd;
  const VF noise2 = hn::Set(F(), energy.noise2), epsilon2 = hn::Set(F(), energy.data_epsilon2),
           gamma = hn::Set(F(), energy.gradient_weight);
  for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(F()))) {
    const VF ax = hn::Sub(load(x1 + i), load(x0 + i)), ay = hn::Sub(load(y1 + i), load(y0 + i));
    const VF x = load(gx.here + i), y = load(gy.here + i), t0 = load(d.here + i);
    const VF xx = half_difference(gx.right + i, gx.left + i),
             xy = half_difference(gx.below + i, gx.above + i),
             yy = half_difference(gy.below + i, gy.above + i);
    const VF xt = half_difference(d.right + i, d.left + i), yt = half_difference(d.below + i, d.above + i);
    // How difference and its gradient change with e.
    const VF r = add(mul(x, ax), mul(y, ay)), rx = add(mul(xx, ax), mul(xy, ay)),
             ry = add(mul(xy, ax), mul(yy, ay));
    // Of the brightness p = w zeta^2 / (D sqrt(zeta^2 t^2 / D + epsilon^2)), D = |grad|^2 + zeta^2, and so
    // on, with no more than one division and one root each.
    const VF ii = add(noise2, add(mul(x, x), mul(y, y))), ix = add(noise2, add(mul(xx, xx), mul(xy, xy))),
             iy = add(noise2, add(mul(xy, xy), mul(yy, yy))), ixy = mul(ix, iy);
    const VF scaled = mul(load(weight + i), noise2);
    const VF bright = mul(ii, add(mul(noise2, mul(t0, t0)), mul(epsilon2, ii)));
    const VF steps = add(mul(iy, mul(xt, xt)), mul(ix, mul(yt, yt)));
    const VF edges = mul(ixy, add(mul(noise2, steps), mul(epsilon2, ixy)));
    const VF p = hn::Div(scaled, hn::Sqrt(bright)), g = hn::Div(mul(scaled, gamma), hn::Sqrt(edges));
    const VF px = mul(g, iy), py = mul(g, ix);
    const VF own = add(mul(p, mul(r, r)), add(mul(px, mul(rx, rx)), mul(py, mul(ry, ry))));
    const VF c = add(mul(p, mul(r, t0)), add(mul(px, mul(rx, xt)), mul(py, mul(ry, yt))));
    hn::StoreU(add(load(a + i), own), F(), a + i);
    hn::StoreU(add(load(b + i), hn::Sub(mul(own, load(e + i)), c)), F(), b + i);
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

HWY_INLINE void differ_half(SplitSpan span, float share, const float* s0, const float* s1, const float* m0,
                            const float* m1, const float* w0, const float* w1, float* HWY_RESTRICT still,
                            float* HWY_RESTRICT moved, float* HWY_RESTRICT said) {
  for (int i = span.begin; i < span.end; ++i) {
    const float weight = share * (w0[i] * w1[i]);
    still[i] += weight * std::abs(s0[i] - s1[i]);
    moved[i] += weight * std::abs(m0[i] - m1[i]);
    said[i] += weight;
  }
}

void DepthDiffer(SplitSpan span, float share, const ComparedRow& first, const ComparedRow& second,
                 const ApartRow& apart) {
  differ_half(span, share, first.still.even, second.still.even, first.moved.even, second.moved.even,
              first.weight.even, second.weight.even, apart.still.even, apart.moved.even, apart.said.even);
  differ_half(span, share, first.still.odd, second.still.odd, first.moved.odd, second.moved.odd,
              first.weight.odd, second.weight.odd, apart.still.odd, apart.moved.odd, apart.said.odd);
}

void DepthSum(int width, const float* apart, float* HWY_RESTRICT sums) {
  for (int x = 0; x < width; ++x)
    sums[x] = (apart[x] + apart[x + 1]) + apart[x + 2] + (apart[x + 3] + apart[x + 4]);
}

HWY_INLINE float sum_of(const std::array<const float*, kBelievedAcross>& rows, int x) {
  return (rows[0][x] + rows[1][x]) + rows[2][x] + (rows[3][x] + rows[4][x]);
}

// What is left of confidence: all without a fault, half where it is usual, nothing from twice that on.
HWY_INLINE float left(float fault, float usual) {
  return std::max(0.F, 1 - fault / (2 * usual + kLeastUsual));
}

void DepthBelieve(int width, float usual, const ApartSums& sums, std::uint8_t* HWY_RESTRICT known) {
  for (int x = 0; x < width; ++x) {
    const float still = sum_of(sums.still, x), moved = sum_of(sums.moved, x), said = sum_of(sums.said, x);
    const float confidence = left(moved, usual * said) * left(moved, still);
    known[x] = static_cast<std::uint8_t>(said > 0 ? 255 * confidence + 0.5F : 0.F);
  }
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
HWY_EXPORT(DepthDiffer);
HWY_EXPORT(DepthSum);
HWY_EXPORT(DepthBelieve);

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

void depth_differ(SplitSpan span, float share, const ComparedRow& first, const ComparedRow& second,
                  const ApartRow& apart) {
  HWY_DYNAMIC_DISPATCH(DepthDiffer)(span, share, first, second, apart);
}

void depth_sum(int width, const float* apart, float* sums) {
  HWY_DYNAMIC_DISPATCH(DepthSum)(width, apart, sums);
}

void depth_believe(int width, float usual, const ApartSums& sums, std::uint8_t* known) {
  HWY_DYNAMIC_DISPATCH(DepthBelieve)(width, usual, sums, known);
}

}  // namespace floatstage::render
#endif
