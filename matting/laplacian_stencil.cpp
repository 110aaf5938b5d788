// Method:  the matting Laplacian: opacity is an affine function of colour in every 3x3 window
// Paper:   A. Levin, D. Lischinski, Y. Weiss, "A closed-form solution to natural image matting", 2008, eq.
//          12
// Differs: made from thin QRs of the windows' colours, never through an inverse of their covariance
//          The arithmetic of windows is compiled for every instruction set that Highway knows here, in one
//          order and without contraction: the same bits on all
// ADR:     0090, 0318

#include "matting/laplacian_stencil.h"

#include <algorithm>
#include <cmath>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matting/laplacian_stencil.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::matting::HWY_NAMESPACE {
namespace {

constexpr int kLanes = 8;    // windows side by side, so that compilers vectorise the arithmetic
constexpr int kMembers = 9;  // pixels of a window, row by row
constexpr int kChannels = 3;

using Lane = std::array<double, kLanes>;

// What the pixels of kLanes neighbouring windows give: one column of the thin Q a channel.
struct Columns {
  std::array<std::array<Lane, kMembers>, kChannels> upper;   // Q1: of the centred colours
  std::array<std::array<Lane, kChannels>, kChannels> lower;  // Q2: of the regularisation
};

void load_centred(const Image& picture, int x, int y, int count, Columns& q) {
  for (int c = 0; c < kChannels; ++c) {
    const int channel = picture.channels == 1 ? 0 : c;
    Lane mean{};
    for (int i = 0; i < kMembers; ++i) {
      const std::uint8_t* row = picture.at(0, y + i / 3 - 1) + channel;
      for (int l = 0; l < kLanes; ++l) {
        const int column = std::min(x + std::min(l, count - 1) + i % 3 - 1, picture.width - 1);
        q.upper[c][i][l] = row[column * picture.channels] / 255.0;
        mean[l] += q.upper[c][i][l];
      }
    }
    for (int i = 0; i < kMembers; ++i)
      for (int l = 0; l < kLanes; ++l) q.upper[c][i][l] -= mean[l] / kMembers;
  }
}

// Subtracts from column c its part along column p.
void remove_part(int p, int c, Columns& q) {
  Lane dot{};
  for (int i = 0; i < kMembers; ++i)
    for (int l = 0; l < kLanes; ++l) dot[l] += q.upper[p][i][l] * q.upper[c][i][l];
  for (int i = 0; i < kChannels; ++i)
    for (int l = 0; l < kLanes; ++l) dot[l] += q.lower[p][i][l] * q.lower[c][i][l];
  for (int i = 0; i < kMembers; ++i)
    for (int l = 0; l < kLanes; ++l) q.upper[c][i][l] -= dot[l] * q.upper[p][i][l];
  for (int i = 0; i < kChannels; ++i)
    for (int l = 0; l < kLanes; ++l) q.lower[c][i][l] -= dot[l] * q.lower[p][i][l];
}

// Gram-Schmidt on [D; sqrt(epsilon) I], every part removed twice: one pass loses orthogonality with the
// condition of the colours (10^4 and more where a window shows one line in colour space), two passes are
// exact to rounding.
void orthonormalize(double epsilon, Columns& q) {
  const double root = std::sqrt(epsilon);
  for (int c = 0; c < kChannels; ++c)
    for (int i = 0; i < kChannels; ++i) q.lower[c][i].fill(i == c ? root : 0.0);
  for (int c = 0; c < kChannels; ++c) {
    for (int pass = 0; pass < 2; ++pass)
      for (int p = 0; p < c; ++p) remove_part(p, c, q);
    Lane square{};
    for (int i = 0; i < kMembers; ++i)
      for (int l = 0; l < kLanes; ++l) square[l] += q.upper[c][i][l] * q.upper[c][i][l];
    for (int i = 0; i < kChannels; ++i)
      for (int l = 0; l < kLanes; ++l) square[l] += q.lower[c][i][l] * q.lower[c][i][l];
    for (int l = 0; l < kLanes; ++l) square[l] = 1 / std::sqrt(square[l]);
    for (int i = 0; i < kMembers; ++i)
      for (int l = 0; l < kLanes; ++l) q.upper[c][i][l] *= square[l];
    for (int i = 0; i < kChannels; ++i)
      for (int l = 0; l < kLanes; ++l) q.lower[c][i][l] *= square[l];
  }
}

bool all_known(const Image& known, int x, int y) {
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (*known.at(x + dx, y + dy) == 0) return false;
  return true;
}

// Adds the off-diagonal entries of the blocks of `count` windows, the first of them centred at (x, y).
void add_blocks(const Columns& q, const Lane& weight, int x, int y, int count, LaplacianStencil& stencil) {
  for (int i = 0; i < kMembers; ++i) {
    const std::size_t first = static_cast<std::size_t>(y + i / 3 - 1) * stencil.width + x + i % 3 - 1;
    for (int j = i + 1; j < kMembers; ++j) {
      Lane block;
      for (int l = 0; l < kLanes; ++l)
        block[l] = -weight[l] * (1.0 / kMembers + q.upper[0][i][l] * q.upper[0][j][l] +
                                 q.upper[1][i][l] * q.upper[1][j][l] + q.upper[2][i][l] * q.upper[2][j][l]);
      double* out = stencil.planes[LaplacianStencil::plane_of(j % 3 - i % 3, j / 3 - i / 3)].data() + first;
      if (count == kLanes)
        for (int l = 0; l < kLanes; ++l) out[l] += block[l];
      else
        for (int l = 0; l < count; ++l) out[l] += block[l];
    }
  }
}

// All windows of a picture that have an unknown pixel.
void add_windows(const Image& picture, double epsilon, const Image& known, LaplacianStencil& stencil) {
  Columns q;
  for (int y = 1; y + 1 < picture.height; ++y) {
    for (int x = 1; x + 1 < picture.width; x += kLanes) {
      const int count = std::min(kLanes, picture.width - 1 - x);
      Lane weight{};
      bool any = false;
      for (int l = 0; l < count; ++l) {
        weight[l] = !known.empty() && all_known(known, x + l, y) ? 0 : 1;
        any = any || weight[l] != 0;
      }
      if (!any) continue;
      load_centred(picture, x, y, count, q);
      orthonormalize(epsilon, q);
      add_blocks(q, weight, x, y, count, stencil);
    }
  }
}

// The diagonal is minus the sum of the rest of its row, so that L 1 = 0 whatever rounding did to the blocks.
void reset_diagonal(LaplacianStencil& stencil) {
  const std::size_t n = stencil.pixels(), row = static_cast<std::size_t>(stencil.width);
  double* diagonal = stencil.planes[0].data();
  for (std::size_t from = 0; from < n; from += row) {
    for (int k = 1; k < LaplacianStencil::kSteps; ++k) {
      const auto [dx, dy] = LaplacianStencil::step(k);
      const std::size_t reach = static_cast<std::size_t>(dy) * row + dx, to = from + row;
      const double* plane = stencil.planes[k].data();
      for (std::size_t p = from; p < std::min(to, n - reach); ++p) diagonal[p] -= plane[p];
      for (std::size_t p = std::max(from, reach); p < to; ++p) diagonal[p] -= plane[p - reach];
    }
  }
}

void table(StencilKernels* out) { *out = {hwy::TargetName(HWY_TARGET), add_windows, reset_diagonal}; }

}  // namespace
}  // namespace floatstage::matting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::matting {

HWY_EXPORT(table);

namespace {

void fill_table(StencilKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

double LaplacianStencil::at(int x, int y, int dx, int dy) const {
  if (dy < 0 || (dy == 0 && dx < 0)) {
    x += dx;
    y += dy;
    dx = -dx;
    dy = -dy;
    if (x < 0 || x >= width || y < 0) return 0;
  }
  return planes[plane_of(dx, dy)][static_cast<std::size_t>(y) * width + x];
}

void build_stencil(const Image& picture, double epsilon, const Image& known, LaplacianStencil& stencil) {
  stencil.width = picture.width;
  stencil.height = picture.height;
  for (std::vector<double>& plane : stencil.planes) plane.assign(stencil.pixels(), 0.0);
  static const StencilKernels best = native_kernels(fill_table);
  best.add_windows(picture, epsilon, known, stencil);
  best.reset_diagonal(stencil);
}

std::vector<StencilKernels> all_stencil_kernels() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::matting
#endif
