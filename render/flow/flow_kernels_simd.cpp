// The kernels in vectors, compiled once for every instruction set that Highway knows here. The operations and
// their order are those of flow_kernels_scalar.cpp: the results are the same bits.

#include <utility>

#include "render/flow/flow_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/flow/flow_kernels_simd.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using F = HWY_CAPPED(float, kSplitBlock);
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
using VU = hn::Vec<U>;

constexpr float kSampleStep = 1.F / 256;
constexpr float kLeastDeterminant = 1e-20F;

HWY_INLINE VF load(const float* at) { return hn::LoadU(F(), at); }
HWY_INLINE void store(VF value, float* at) { hn::StoreU(value, F(), at); }
HWY_INLINE VF set(float value) { return hn::Set(F(), value); }
HWY_INLINE VF mul(VF a, VF b) { return hn::Mul(a, b); }
HWY_INLINE VF add(VF a, VF b) { return hn::Add(a, b); }
HWY_INLINE VF sub(VF a, VF b) { return hn::Sub(a, b); }
HWY_INLINE VF half_difference(VF a, VF b) { return mul(set(0.5F), sub(a, b)); }

/// Two samples side by side, each in a lane of its own; `known` has their lowest bits in bits 0 and 16.
struct Taps {
  VF low, high;
  VU words;
};

HWY_INLINE Taps taps(const std::uint16_t* origin, VI offset) {
  const VU words =
      hn::BitCast(U(), hn::GatherOffset(I(), reinterpret_cast<const std::int32_t*>(origin), offset));
  const VU mask = hn::Set(U(), 0xFFFEU);
  auto to_float = [](VU v) { return hn::ConvertTo(F(), hn::BitCast(I(), v)); };
  return {to_float(hn::And(words, mask)), to_float(hn::And(hn::ShiftRight<16>(words), mask)), words};
}

HWY_INLINE VF known_of(VU bits) {
  return hn::ConvertTo(F(), hn::BitCast(I(), hn::And(bits, hn::Set(U(), 1U))));
}

struct Sample {
  VF value, known;
};

HWY_INLINE VI offset_of(const SampledPicture& p, VI x, VI y) {
  const I d;
  return hn::ShiftLeft<1>(hn::Add(hn::Mul(y, hn::Set(d, p.stride)), x));  // in bytes
}

HWY_INLINE Sample bilinear(const SampledPicture& p, VI x, VI y, VF fx, VF fy) {
  const VI at = offset_of(p, x, y);
  const Taps top = taps(p.origin, at), bottom = taps(p.origin + p.stride, at);
  const VF a = add(top.low, mul(fx, sub(top.high, top.low)));
  const VF b = add(bottom.low, mul(fx, sub(bottom.high, bottom.low)));
  const VU both = hn::And(top.words, bottom.words);
  return {mul(add(a, mul(fy, sub(b, a))), set(kSampleStep)),
          known_of(hn::And(both, hn::ShiftRight<16>(both)))};
}

struct CubicWeights {
  VF w0, w1, w2, w3;
};

HWY_INLINE CubicWeights cubic_weights(VF t) {
  const VF t2 = mul(t, t), t3 = mul(t2, t), half = set(0.5F);
  return {mul(half, sub(add(t2, t2), add(t, t3))), add(set(1.F), sub(mul(set(1.5F), t3), mul(set(2.5F), t2))),
          mul(half, sub(add(mul(set(4.F), t2), t), mul(set(3.F), t3))), mul(half, sub(t3, t2))};
}

HWY_INLINE Sample cubic(const SampledPicture& p, VI x, VI y, VF fx, VF fy) {
  const CubicWeights wx = cubic_weights(fx), wy = cubic_weights(fy);
  const VI at = offset_of(p, x, y);
  const std::uint16_t* rows = p.origin - p.stride - 1;
  VF sum = hn::Zero(F());
  VU known = hn::Set(U(), 1U);
  auto row = [&](const VF& weight, bool middle) HWY_ATTR {
    const Taps left = taps(rows, at), right = taps(rows + 2, at);
    const VF value = add(add(add(mul(wx.w0, left.low), mul(wx.w1, left.high)), mul(wx.w2, right.low)),
                         mul(wx.w3, right.high));
    sum = add(sum, mul(weight, value));
    if (middle) known = hn::And(known, hn::And(hn::ShiftRight<16>(left.words), right.words));
    rows += p.stride;
  };
  row(wy.w0, false);
  row(wy.w1, true);
  row(wy.w2, true);
  row(wy.w3, false);
  return {mul(sum, set(kSampleStep)), known_of(known)};
}

template <bool kCubic>
void warp_half(SplitSpan span, int parity, int y, const float* u, const float* v, const float* first,
               const float* data, const SampledPicture& p, float* mean, float* difference, float* weight) {
  const F d;
  const I di;
  const VF least = set(-1.F), width = set(static_cast<float>(p.width)),
           height = set(static_cast<float>(p.height)), line = set(static_cast<float>(y));
  for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(d))) {
    const VI column = hn::ShiftLeft<1>(hn::Iota(di, i));
    const VF here = hn::ConvertTo(d, hn::Add(column, hn::Set(di, parity)));
    const VF x = hn::Min(hn::Max(add(here, load(u + i)), least), width);
    const VF row = hn::Min(hn::Max(add(line, load(v + i)), least), height);
    const VF x0 = hn::Floor(x), y0 = hn::Floor(row);
    const VI xi = hn::ConvertTo(di, x0), yi = hn::ConvertTo(di, y0);
    const Sample s =
        kCubic ? cubic(p, xi, yi, sub(x, x0), sub(row, y0)) : bilinear(p, xi, yi, sub(x, x0), sub(row, y0));
    const VF one = load(first + i);
    store(mul(set(0.5F), add(one, s.value)), mean + i);
    store(sub(s.value, one), difference + i);
    store(mul(load(data + i), s.known), weight + i);
  }
}

void warp(SplitSpan span, int y, bool use_cubic, ConstSplitRow u, ConstSplitRow v, ConstSplitRow first,
          ConstSplitRow data, const SampledPicture& second, SplitRow mean, SplitRow difference,
          SplitRow weight) {
  const auto half = use_cubic ? warp_half<true> : warp_half<false>;
  half(span, 0, y, u.even, v.even, first.even, data.even, second, mean.even, difference.even, weight.even);
  half(span, 1, y, u.odd, v.odd, first.odd, data.odd, second, mean.odd, difference.odd, weight.odd);
}

void gradient(SplitSpan span, const ThreeRows& mean, SplitRow dx, SplitRow dy) {
  for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(F()))) {
    const VF even = load(mean.here.even + i), odd = load(mean.here.odd + i);
    store(half_difference(odd, load(mean.here.odd + i - 1)), dx.even + i);
    store(half_difference(load(mean.here.even + i + 1), even), dx.odd + i);
    store(half_difference(load(mean.below.even + i), load(mean.above.even + i)), dy.even + i);
    store(half_difference(load(mean.below.odd + i), load(mean.above.odd + i)), dy.odd + i);
  }
}

HWY_INLINE VF diffusivity_of(VF u, VF u_right, VF u_below, VF v, VF v_right, VF v_below, VF stiffness,
                             VF epsilon2) {
  const VF ux = sub(u_right, u), uy = sub(u_below, u), vx = sub(v_right, v), vy = sub(v_below, v);
  const VF squares = add(add(mul(ux, ux), mul(uy, uy)), add(mul(vx, vx), mul(vy, vy)));
  return hn::Div(stiffness, hn::Sqrt(add(squares, epsilon2)));
}

void diffusivity(SplitSpan span, const FlowEnergy& energy, ConstSplitRow u, ConstSplitRow u_below,
                 ConstSplitRow v, ConstSplitRow v_below, ConstSplitRow stiffness, SplitRow out) {
  const VF e = set(energy.smooth_epsilon2);
  for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(F()))) {
    const VF ue = load(u.even + i), uo = load(u.odd + i), ve = load(v.even + i), vo = load(v.odd + i);
    store(diffusivity_of(ue, uo, load(u_below.even + i), ve, vo, load(v_below.even + i),
                         load(stiffness.even + i), e),
          out.even + i);
    store(diffusivity_of(uo, load(u.even + i + 1), load(u_below.odd + i), vo, load(v.even + i + 1),
                         load(v_below.odd + i), load(stiffness.odd + i), e),
          out.odd + i);
  }
}

void neighbors(SplitSpan span, ConstSplitRow here, ConstSplitRow below, SplitRow right, SplitRow down) {
  for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(F()))) {
    const VF even = load(here.even + i), odd = load(here.odd + i);
    store(hn::Sqrt(mul(even, odd)), right.even + i);
    store(hn::Sqrt(mul(odd, load(here.even + i + 1))), right.odd + i);
    store(hn::Sqrt(mul(even, load(below.even + i))), down.even + i);
    store(hn::Sqrt(mul(odd, load(below.odd + i))), down.odd + i);
  }
}

struct Derivatives {
  VF x, y, t, xx, xy, yy, xt, yt;
};

struct EquationHalf {
  const float *dx, *dx_left, *dx_right, *dx_above, *dx_below;
  const float *dy, *dy_above, *dy_below;
  const float *t, *t_left, *t_right, *t_above, *t_below;
  const float *weight, *u, *v, *right, *left, *down, *up;
  float *i11, *i12, *i22, *b1, *b2;
};

HWY_INLINE Derivatives derivatives(const EquationHalf& h, int i) {
  return {load(h.dx + i),
          load(h.dy + i),
          load(h.t + i),
          half_difference(load(h.dx_right + i), load(h.dx_left + i)),
          half_difference(load(h.dx_below + i), load(h.dx_above + i)),
          half_difference(load(h.dy_below + i), load(h.dy_above + i)),
          half_difference(load(h.t_right + i), load(h.t_left + i)),
          half_difference(load(h.t_below + i), load(h.t_above + i))};
}

/// a c + b d, each product with a weight: p (ab) + (px (cd) + py (ef)).
HWY_INLINE VF weighted(VF p, VF ab, VF px, VF cd, VF py, VF ef) {
  return add(mul(p, ab), add(mul(px, cd), mul(py, ef)));
}

HWY_INLINE void equation_of(const EquationHalf& h, int i, const FlowEnergy& e) {
  const Derivatives d = derivatives(h, i);
  const VF one = set(1.F), noise2 = set(e.noise2), epsilon2 = set(e.data_epsilon2);
  const VF x2 = mul(d.x, d.x), y2 = mul(d.y, d.y), xx2 = mul(d.xx, d.xx), xy2 = mul(d.xy, d.xy),
           yy2 = mul(d.yy, d.yy);
  const VF theta = hn::Div(one, add(add(x2, y2), noise2));
  const VF theta_x = hn::Div(one, add(add(xx2, xy2), noise2));
  const VF theta_y = hn::Div(one, add(add(xy2, yy2), noise2));
  const VF bright = mul(noise2, mul(theta, mul(d.t, d.t)));
  const VF grad = mul(noise2, add(mul(theta_x, mul(d.xt, d.xt)), mul(theta_y, mul(d.yt, d.yt))));
  const VF scaled = mul(load(h.weight + i), noise2);
  const VF p = hn::Div(mul(scaled, theta), hn::Sqrt(add(bright, epsilon2)));
  const VF g = hn::Div(mul(scaled, set(e.gradient_weight)), hn::Sqrt(add(grad, epsilon2)));
  const VF px = mul(g, theta_x), py = mul(g, theta_y);
  const VF j11 = weighted(p, x2, px, xx2, py, xy2);
  const VF j12 = weighted(p, mul(d.x, d.y), px, mul(d.xx, d.xy), py, mul(d.xy, d.yy));
  const VF j22 = weighted(p, y2, px, xy2, py, yy2);
  const VF c1 = weighted(p, mul(d.x, d.t), px, mul(d.xx, d.xt), py, mul(d.xy, d.yt));
  const VF c2 = weighted(p, mul(d.y, d.t), px, mul(d.xy, d.xt), py, mul(d.yy, d.yt));
  const VF springs = add(add(load(h.right + i), load(h.left + i)), add(load(h.down + i), load(h.up + i)));
  const VF own = hn::Max(sub(mul(j11, j22), mul(j12, j12)), hn::Zero(F()));
  const VF determinant = add(own, mul(springs, add(add(j11, j22), springs)));
  const VF scale = hn::Div(set(e.omega), hn::Max(determinant, set(kLeastDeterminant)));
  const VF u = load(h.u + i), v = load(h.v + i);
  store(mul(add(j22, springs), scale), h.i11 + i);
  store(mul(j12, scale), h.i12 + i);
  store(mul(add(j11, springs), scale), h.i22 + i);
  store(sub(add(mul(j11, u), mul(j12, v)), c1), h.b1 + i);
  store(sub(add(mul(j12, u), mul(j22, v)), c2), h.b2 + i);
}

void equations(SplitSpan span, const FlowEnergy& energy, const ThreeRows& dx, const ThreeRows& dy,
               const ThreeRows& t, ConstSplitRow weight, ConstSplitRow u, ConstSplitRow v,
               ConstSplitRow right, ConstSplitRow down, ConstSplitRow down_above, const EquationRow& out) {
  const EquationHalf even{dx.here.even, dx.here.odd - 1, dx.here.odd,   dx.above.even, dx.below.even,
                          dy.here.even, dy.above.even,   dy.below.even, t.here.even,   t.here.odd - 1,
                          t.here.odd,   t.above.even,    t.below.even,  weight.even,   u.even,
                          v.even,       right.even,      right.odd - 1, down.even,     down_above.even,
                          out.i11.even, out.i12.even,    out.i22.even,  out.b1.even,   out.b2.even};
  const EquationHalf odd{dx.here.odd,     dx.here.even, dx.here.even + 1, dx.above.odd, dx.below.odd,
                         dy.here.odd,     dy.above.odd, dy.below.odd,     t.here.odd,   t.here.even,
                         t.here.even + 1, t.above.odd,  t.below.odd,      weight.odd,   u.odd,
                         v.odd,           right.odd,    right.even,       down.odd,     down_above.odd,
                         out.i11.odd,     out.i12.odd,  out.i22.odd,      out.b1.odd,   out.b2.odd};
  for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(F()))) equation_of(even, i, energy);
  for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(F()))) equation_of(odd, i, energy);
}

struct RelaxHalf {
  const float *i11, *i12, *i22, *b1, *b2, *w_right, *w_left, *w_down, *w_up;
  const float *u_left, *u_right, *u_up, *u_down, *v_left, *v_right, *v_up, *v_down;
  float *u, *v;
};

/// b + sum of the neighbours' pull.
HWY_INLINE VF pull(VF b, VF wr, const float* right, VF wl, const float* left, VF wd, const float* down, VF wu,
                   const float* up) {
  return add(
      b, add(add(mul(wr, load(right)), mul(wl, load(left))), add(mul(wd, load(down)), mul(wu, load(up)))));
}

HWY_INLINE void relax_half(SplitSpan span, float omega, const RelaxHalf& h) {
  const VF keep = set(1.F - omega);
  for (int i = span.begin; i < span.end; i += static_cast<int>(hn::Lanes(F()))) {
    const VF wr = load(h.w_right + i), wl = load(h.w_left + i), wd = load(h.w_down + i),
             wu = load(h.w_up + i);
    const VF su = pull(load(h.b1 + i), wr, h.u_right + i, wl, h.u_left + i, wd, h.u_down + i, wu, h.u_up + i);
    const VF sv = pull(load(h.b2 + i), wr, h.v_right + i, wl, h.v_left + i, wd, h.v_down + i, wu, h.v_up + i);
    const VF i12 = load(h.i12 + i);
    store(add(mul(keep, load(h.u + i)), sub(mul(load(h.i11 + i), su), mul(i12, sv))), h.u + i);
    store(add(mul(keep, load(h.v + i)), sub(mul(load(h.i22 + i), sv), mul(i12, su))), h.v + i);
  }
}

void relax(SplitSpan span, int parity, float omega, const EquationRow& q, ConstSplitRow right,
           ConstSplitRow down, ConstSplitRow down_above, const ThreeRows& u, const ThreeRows& v,
           SplitRow u_out, SplitRow v_out) {
  if (parity == 0)
    relax_half(span, omega,
               {q.i11.even, q.i12.even, q.i22.even, q.b1.even, q.b2.even, right.even, right.odd - 1,
                down.even, down_above.even, u.here.odd - 1, u.here.odd, u.above.even, u.below.even,
                v.here.odd - 1, v.here.odd, v.above.even, v.below.even, u_out.even, v_out.even});
  else
    relax_half(span, omega,
               {q.i11.odd, q.i12.odd, q.i22.odd, q.b1.odd, q.b2.odd, right.odd, right.even, down.odd,
                down_above.odd, u.here.even, u.here.even + 1, u.above.odd, u.below.odd, v.here.even,
                v.here.even + 1, v.above.odd, v.below.odd, u_out.odd, v_out.odd});
}

void table(FlowKernels* out) {
  *out = {hwy::TargetName(HWY_TARGET), warp, gradient, diffusivity, neighbors, equations, relax};
}

}  // namespace
}  // namespace floatstage::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render {

HWY_EXPORT(table);

namespace {

void fill_table(FlowKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

const FlowKernels& native_flow_kernels() {
  static const FlowKernels best = native_kernels(fill_table);
  return best;
}

std::vector<FlowKernels> all_flow_kernels() {
  std::vector<FlowKernels> all = kernels_of_all_sets(fill_table);
  all.insert(all.begin(), scalar_flow_kernels());
  return all;
}

}  // namespace floatstage::render
#endif
