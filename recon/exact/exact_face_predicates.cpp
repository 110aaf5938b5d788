#include <cmath>

#include "recon/exact/exact_face.h"

// The decisions of the sweep. Without a grid, doubles decide. With one, the doubles are rounded from exact
// integers, so their relative errors are a few 2^-53; where a result is not larger than its error, integers
// decide.

namespace floatstage::recon {
namespace {

constexpr double kEpsilon = 1e-14;  // about 45 roundings

}  // namespace

/// det(C_j - C_i, d_a, q) and det(C_j - C_i, d_b, q) for the ray q at this end: opposite signs, s = ta / (ta
/// - tb).
std::pair<Int128, Int128> FaceSweep::exact_sides(const End& end, int view) const {
  const GridViews& grid = *in_->grid;
  const GridViews::Vector baseline = grid.centers[view] - grid.centers[i_];
  // Components of the plane's normal: 28 + 28 + 1 bits; times the baseline's 27 bits, summed.
  const auto side_of = [&](int ray) {
    return dot(cross(grid.rays[i_][ray], grid.rays[view][end.ray]), baseline);
  };
  return {side_of(a_), side_of(b_)};
}

bool FaceSweep::exactly_before(const End& x, int x_view, const End& y, int y_view) {
  if (x.ray == kClipped || y.ray == kClipped) return x.s < y.s;  // no decision of the hull's
  if (x.ray == kSide || y.ray == kSide) {
    const int x_rank = x.ray >= 0 ? 1 : (x.s > 0.5 ? 2 : 0), y_rank = y.ray >= 0 ? 1 : (y.s > 0.5 ? 2 : 0);
    return x_rank < y_rank;
  }
  if (std::abs(x.s - y.s) > kEpsilon) return x.s < y.s;
  if (x_view == y_view && x.ray == y.ray) return false;
  const auto [xa, xb] = exact_sides(x, x_view);
  const auto [ya, yb] = exact_sides(y, y_view);
  // xa / (xa - xb) - ya / (ya - yb)
  const int sign = (Wide(xb) * Wide(ya) - Wide(xa) * Wide(yb)).sign() * sign_of(xa - xb) * sign_of(ya - yb);
  tie_ |= sign == 0;
  return sign < 0;
}

int FaceSweep::exact_side(int f_index, int g_index, const End& at, int at_view) {
  const Line &f = lines_[f_index], &g = lines_[g_index];
  const double at_a = f.wa - g.wa, at_b = f.wb - g.wb;
  const double difference = at_a + (at_b - at_a) * at.s;
  const double size = std::abs(f.wa) + std::abs(g.wa) + std::abs(f.wb) + std::abs(g.wb);
  if (std::abs(difference) > kEpsilon * size || at.ray == kClipped) return difference >= 0 ? 1 : -1;
  const ExactLine &x = exact_[f_index], &y = exact_[g_index];
  const Wide exact_a = Wide(x.above_a) * Wide(y.below) - Wide(y.above_a) * Wide(x.below);
  const Wide exact_b = Wide(x.above_b) * Wide(y.below) - Wide(y.above_b) * Wide(x.below);
  int sign;
  if (at.ray == kSide) {
    sign = (at.s > 0.5 ? exact_b : exact_a).sign();
  } else {
    const auto [ta, tb] = exact_sides(at, at_view);
    sign = (exact_b * Wide(ta) - exact_a * Wide(tb)).sign() * sign_of(ta - tb);
  }
  sign *= sign_of(x.below) * sign_of(y.below);
  tie_ |= sign == 0;
  return sign >= 0 ? 1 : -1;
}

bool FaceSweep::exactly_crosses_before(int f_index, const Crossing& first, const Crossing& second) {
  if (first.line == second.line) return false;
  const Line &f = lines_[f_index], &g = lines_[first.line], &h = lines_[second.line];
  const double ga = f.wa - g.wa, gb = f.wb - g.wb, ha = f.wa - h.wa, hb = f.wb - h.wb;
  const double difference = gb * ha - ga * hb, denominator_g = ga - gb, denominator_h = ha - hb;
  const double size_g = std::abs(f.wa) + std::abs(g.wa) + std::abs(f.wb) + std::abs(g.wb);
  const double size_h = std::abs(f.wa) + std::abs(h.wa) + std::abs(f.wb) + std::abs(h.wb);
  if (std::abs(denominator_g) > kEpsilon * size_g && std::abs(denominator_h) > kEpsilon * size_h &&
      std::abs(difference) > 4 * kEpsilon * size_g * size_h) {
    // ga / (ga - gb) < ha / (ha - hb)
    return (difference < 0) == ((denominator_g > 0) == (denominator_h > 0));
  }
  const ExactLine& x = exact_[f_index];
  const auto exact = [&](int other, bool b) {
    const ExactLine& y = exact_[other];
    return Wide(b ? x.above_b : x.above_a) * Wide(y.below) - Wide(b ? y.above_b : y.above_a) * Wide(x.below);
  };
  const Wide exact_ga = exact(first.line, false), exact_gb = exact(first.line, true);
  const Wide exact_ha = exact(second.line, false), exact_hb = exact(second.line, true);
  const int sign = (exact_gb * exact_ha - exact_ga * exact_hb).sign() * (exact_ga - exact_gb).sign() *
                   (exact_ha - exact_hb).sign();
  tie_ |= sign == 0;
  return sign < 0;
}

}  // namespace floatstage::recon
