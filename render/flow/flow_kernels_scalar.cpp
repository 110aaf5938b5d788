#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/flow/flow_kernels.h"

// The reference: one pixel after the other. flow_kernels_simd.cpp does the same in vectors, operation by
// operation; neither may be contracted to fused multiply-adds (render/CMakeLists.txt sees to it).

namespace floatstage::render {
namespace {

constexpr float kSampleStep = 1.F / 256;  // of a sample without its lowest bit
constexpr float kLeastDeterminant = 1e-20F;

struct Taps {
  float low, high;
  std::uint32_t low_known, high_known;
};

/// Two samples side by side.
Taps taps(const std::uint16_t* at) {
  return {static_cast<float>(at[0] & 0xFFFEU), static_cast<float>(at[1] & 0xFFFEU), at[0] & 1U, at[1] & 1U};
}

struct CubicWeights {
  float w[4];
};

/// Catmull-Rom at t in [0, 1): exactly (0, 1, 0, 0) at 0.
CubicWeights cubic_weights(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {{0.5F * ((t2 + t2) - (t + t3)), 1.F + (1.5F * t3 - 2.5F * t2), 0.5F * ((4.F * t2 + t) - 3.F * t3),
           0.5F * (t3 - t2)}};
}

struct Sample {
  float value, known;
};

Sample bilinear(const SampledPicture& p, int x, int y, float fx, float fy) {
  const std::uint16_t* at = p.origin + static_cast<std::ptrdiff_t>(y) * p.stride + x;
  const Taps top = taps(at), bottom = taps(at + p.stride);
  const float a = top.low + fx * (top.high - top.low), b = bottom.low + fx * (bottom.high - bottom.low);
  const std::uint32_t known = top.low_known & top.high_known & bottom.low_known & bottom.high_known;
  return {(a + fy * (b - a)) * kSampleStep, static_cast<float>(known)};
}

Sample cubic(const SampledPicture& p, int x, int y, float fx, float fy) {
  const CubicWeights wx = cubic_weights(fx), wy = cubic_weights(fy);
  const std::uint16_t* at = p.origin + static_cast<std::ptrdiff_t>(y - 1) * p.stride + x - 1;
  float sum = 0;
  std::uint32_t known = 1;
  for (int j = 0; j < 4; ++j, at += p.stride) {
    const Taps left = taps(at), right = taps(at + 2);
    const float row =
        ((wx.w[0] * left.low + wx.w[1] * left.high) + wx.w[2] * right.low) + wx.w[3] * right.high;
    sum = sum + wy.w[j] * row;
    if (j == 1 || j == 2) known = known & left.high_known & right.low_known;
  }
  return {sum * kSampleStep, static_cast<float>(known)};
}

void warp_half(SplitSpan span, int parity, int y, bool use_cubic, const float* u, const float* v,
               const float* first, const float* data, const SampledPicture& p, float* mean, float* difference,
               float* weight) {
  for (int i = span.begin; i < span.end; ++i) {
    const float x =
        std::min(std::max(static_cast<float>(2 * i + parity) + u[i], -1.F), static_cast<float>(p.width));
    const float row = std::min(std::max(static_cast<float>(y) + v[i], -1.F), static_cast<float>(p.height));
    const float x0 = std::floor(x), y0 = std::floor(row);
    const Sample s = use_cubic ? cubic(p, static_cast<int>(x0), static_cast<int>(y0), x - x0, row - y0)
                               : bilinear(p, static_cast<int>(x0), static_cast<int>(y0), x - x0, row - y0);
    mean[i] = 0.5F * (first[i] + s.value);
    difference[i] = s.value - first[i];
    weight[i] = data[i] * s.known;
  }
}

void warp(SplitSpan span, int y, bool use_cubic, ConstSplitRow u, ConstSplitRow v, ConstSplitRow first,
          ConstSplitRow data, const SampledPicture& second, SplitRow mean, SplitRow difference,
          SplitRow weight) {
  warp_half(span, 0, y, use_cubic, u.even, v.even, first.even, data.even, second, mean.even, difference.even,
            weight.even);
  warp_half(span, 1, y, use_cubic, u.odd, v.odd, first.odd, data.odd, second, mean.odd, difference.odd,
            weight.odd);
}

void gradient(SplitSpan span, const ThreeRows& mean, SplitRow dx, SplitRow dy) {
  for (int i = span.begin; i < span.end; ++i) {
    dx.even[i] = 0.5F * (mean.here.odd[i] - mean.here.odd[i - 1]);
    dx.odd[i] = 0.5F * (mean.here.even[i + 1] - mean.here.even[i]);
    dy.even[i] = 0.5F * (mean.below.even[i] - mean.above.even[i]);
    dy.odd[i] = 0.5F * (mean.below.odd[i] - mean.above.odd[i]);
  }
}

float diffusivity_of(float u, float u_right, float u_below, float v, float v_right, float v_below,
                     float stiffness, float epsilon2) {
  const float ux = u_right - u, uy = u_below - u, vx = v_right - v, vy = v_below - v;
  const float squares = (ux * ux + uy * uy) + (vx * vx + vy * vy);
  return stiffness / std::sqrt(squares + epsilon2);
}

void diffusivity(SplitSpan span, const FlowEnergy& energy, ConstSplitRow u, ConstSplitRow u_below,
                 ConstSplitRow v, ConstSplitRow v_below, ConstSplitRow stiffness, SplitRow out) {
  const float e = energy.smooth_epsilon2;
  for (int i = span.begin; i < span.end; ++i) {
    out.even[i] = diffusivity_of(u.even[i], u.odd[i], u_below.even[i], v.even[i], v.odd[i], v_below.even[i],
                                 stiffness.even[i], e);
    out.odd[i] = diffusivity_of(u.odd[i], u.even[i + 1], u_below.odd[i], v.odd[i], v.even[i + 1],
                                v_below.odd[i], stiffness.odd[i], e);
  }
}

void neighbors(SplitSpan span, ConstSplitRow here, ConstSplitRow below, SplitRow right, SplitRow down) {
  for (int i = span.begin; i < span.end; ++i) {
    right.even[i] = std::sqrt(here.even[i] * here.odd[i]);
    right.odd[i] = std::sqrt(here.odd[i] * here.even[i + 1]);
    down.even[i] = std::sqrt(here.even[i] * below.even[i]);
    down.odd[i] = std::sqrt(here.odd[i] * below.odd[i]);
  }
}

/// The derivatives at one pixel.
struct Derivatives {
  float x, y, t, xx, xy, yy, xt, yt;
};

struct PixelEquation {
  float i11, i12, i22, b1, b2;
};

PixelEquation equation_of(const Derivatives& d, float weight, float u, float v, float springs,
                          const FlowEnergy& e) {
  const float theta = 1.F / ((d.x * d.x + d.y * d.y) + e.noise2);
  const float theta_x = 1.F / ((d.xx * d.xx + d.xy * d.xy) + e.noise2);
  const float theta_y = 1.F / ((d.xy * d.xy + d.yy * d.yy) + e.noise2);
  const float bright = e.noise2 * (theta * (d.t * d.t));
  const float grad = e.noise2 * (theta_x * (d.xt * d.xt) + theta_y * (d.yt * d.yt));
  const float scaled = weight * e.noise2;
  const float p = (scaled * theta) / std::sqrt(bright + e.data_epsilon2);
  const float g = (scaled * e.gradient_weight) / std::sqrt(grad + e.data_epsilon2);
  const float px = g * theta_x, py = g * theta_y;
  const float j11 = p * (d.x * d.x) + (px * (d.xx * d.xx) + py * (d.xy * d.xy));
  const float j12 = p * (d.x * d.y) + (px * (d.xx * d.xy) + py * (d.xy * d.yy));
  const float j22 = p * (d.y * d.y) + (px * (d.xy * d.xy) + py * (d.yy * d.yy));
  const float c1 = p * (d.x * d.t) + (px * (d.xx * d.xt) + py * (d.xy * d.yt));
  const float c2 = p * (d.y * d.t) + (px * (d.xy * d.xt) + py * (d.yy * d.yt));
  // The determinant of J alone is a difference of large numbers: it may not fall below 0.
  const float own = std::max(j11 * j22 - j12 * j12, 0.F);
  const float scale = e.omega / std::max(own + springs * ((j11 + j22) + springs), kLeastDeterminant);
  return {(j22 + springs) * scale, j12 * scale, (j11 + springs) * scale, (j11 * u + j12 * v) - c1,
          (j12 * u + j22 * v) - c2};
}

Derivatives derivatives(int i, int left, int right, const float* dx, const float* dx_other,
                        const float* dx_above, const float* dx_below, const float* dy, const float* dy_above,
                        const float* dy_below, const float* t, const float* t_other, const float* t_above,
                        const float* t_below) {
  return {dx[i],
          dy[i],
          t[i],
          0.5F * (dx_other[right] - dx_other[left]),
          0.5F * (dx_below[i] - dx_above[i]),
          0.5F * (dy_below[i] - dy_above[i]),
          0.5F * (t_other[right] - t_other[left]),
          0.5F * (t_below[i] - t_above[i])};
}

void equations(SplitSpan span, const FlowEnergy& energy, const ThreeRows& dx, const ThreeRows& dy,
               const ThreeRows& t, ConstSplitRow weight, ConstSplitRow u, ConstSplitRow v,
               ConstSplitRow right, ConstSplitRow down, ConstSplitRow down_above, const EquationRow& out) {
  auto store = [&](const PixelEquation& q, int i, bool odd) {
    (odd ? out.i11.odd : out.i11.even)[i] = q.i11;
    (odd ? out.i12.odd : out.i12.even)[i] = q.i12;
    (odd ? out.i22.odd : out.i22.even)[i] = q.i22;
    (odd ? out.b1.odd : out.b1.even)[i] = q.b1;
    (odd ? out.b2.odd : out.b2.even)[i] = q.b2;
  };
  for (int i = span.begin; i < span.end; ++i) {
    const Derivatives even =
        derivatives(i, i - 1, i, dx.here.even, dx.here.odd, dx.above.even, dx.below.even, dy.here.even,
                    dy.above.even, dy.below.even, t.here.even, t.here.odd, t.above.even, t.below.even);
    const float even_springs = (right.even[i] + right.odd[i - 1]) + (down.even[i] + down_above.even[i]);
    store(equation_of(even, weight.even[i], u.even[i], v.even[i], even_springs, energy), i, false);
    const Derivatives odd =
        derivatives(i, i, i + 1, dx.here.odd, dx.here.even, dx.above.odd, dx.below.odd, dy.here.odd,
                    dy.above.odd, dy.below.odd, t.here.odd, t.here.even, t.above.odd, t.below.odd);
    const float odd_springs = (right.odd[i] + right.even[i]) + (down.odd[i] + down_above.odd[i]);
    store(equation_of(odd, weight.odd[i], u.odd[i], v.odd[i], odd_springs, energy), i, true);
  }
}

struct RelaxHalf {
  const float *i11, *i12, *i22, *b1, *b2, *w_right, *w_left, *w_down, *w_up;
  const float *u_other, *u_up, *u_down, *v_other, *v_up, *v_down;
  float *u, *v;
  int left, right;  // offsets of the horizontal neighbours in the other half, and of w_left
};

void relax_half(SplitSpan span, float omega, const RelaxHalf& h) {
  const float keep = 1.F - omega;
  for (int i = span.begin; i < span.end; ++i) {
    const float wr = h.w_right[i], wl = h.w_left[i + h.left], wd = h.w_down[i], wu = h.w_up[i];
    const float su = h.b1[i] + ((wr * h.u_other[i + h.right] + wl * h.u_other[i + h.left]) +
                                (wd * h.u_down[i] + wu * h.u_up[i]));
    const float sv = h.b2[i] + ((wr * h.v_other[i + h.right] + wl * h.v_other[i + h.left]) +
                                (wd * h.v_down[i] + wu * h.v_up[i]));
    h.u[i] = keep * h.u[i] + (h.i11[i] * su - h.i12[i] * sv);
    h.v[i] = keep * h.v[i] + (h.i22[i] * sv - h.i12[i] * su);
  }
}

void relax(SplitSpan span, int parity, float omega, const EquationRow& q, ConstSplitRow right,
           ConstSplitRow down, ConstSplitRow down_above, const ThreeRows& u, const ThreeRows& v,
           SplitRow u_out, SplitRow v_out) {
  if (parity == 0)
    relax_half(span, omega,
               {q.i11.even, q.i12.even, q.i22.even, q.b1.even, q.b2.even, right.even, right.odd, down.even,
                down_above.even, u.here.odd, u.above.even, u.below.even, v.here.odd, v.above.even,
                v.below.even, u_out.even, v_out.even, -1, 0});
  else
    relax_half(span, omega,
               {q.i11.odd, q.i12.odd, q.i22.odd, q.b1.odd, q.b2.odd, right.odd, right.even, down.odd,
                down_above.odd, u.here.even, u.above.odd, u.below.odd, v.here.even, v.above.odd, v.below.odd,
                u_out.odd, v_out.odd, 0, 1});
}

}  // namespace

const FlowKernels& scalar_flow_kernels() {
  static const FlowKernels kernels{"scalar", warp, gradient, diffusivity, neighbors, equations, relax};
  return kernels;
}

}  // namespace floatstage::render
