// Method:  conjugate gradients, preconditioned by the diagonal
// Paper:   J. R. Shewchuk, "An introduction to the conjugate gradient method without the agonizing pain",
//          1994, B3
// Differs: rows of L are packed in blocks of eight pixels; numbers of 32 bits, sums of 64. Compiled for
//          every instruction set that Highway knows here, in one order, without contraction: the same bits
// ADR:     0318

#include "matting/held_solver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matting/held_solver.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::matting::HWY_NAMESPACE {
namespace {

constexpr int kLanes = 8;                                                // pixels of a block
constexpr int kReach = 2;                                                // px: rows of L reach this far
constexpr int kHalf = LaplacianStencil::kSteps, kSteps = 2 * kHalf - 1;  // of half a row of L, and of a row
constexpr double kHeld = 1e-2;  // of a pixel at least; entries of L are of the order of 1
constexpr double kResidual =
    1e-6;  // of a pixel, by its diagonal, on average: leaves errors of 1e-4 (hold 0.05)
constexpr int kMostPasses = 300;

using Lanes = std::array<float, kLanes>;
using Vector = std::vector<Lanes>;  // a number a pixel, block by block; 0 where a pixel takes no part

double dot(const Vector& a, const Vector& b) {
  std::array<double, kLanes> sums{};
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int l = 0; l < kLanes; ++l) sums[l] += static_cast<double>(a[i][l]) * static_cast<double>(b[i][l]);
  double sum = 0;
  for (const double s : sums) sum += s;
  return sum;
}

// L + diag(weight), in blocks of eight neighbours in a row of the picture.
class HeldSystem {
 public:
  HeldSystem(const LaplacianStencil& stencil, const std::vector<std::uint8_t>& active,
             const std::vector<double>& weight);

  std::size_t blocks() const { return blocks_.size(); }
  /// The product with `in`, and with the inverse of the diagonal.
  void multiply(const Vector& in, Vector& out);
  void precondition(const Vector& in, Vector& out) const;
  /// Of numbers a pixel of the picture, and back.
  Vector packed(const std::vector<double>& picture) const;
  std::vector<double> picture_of(const Vector& numbers) const;

 private:
  struct Block {
    std::size_t pixel;  // its first, in the picture
    std::size_t at;     // and in the grid
    Lanes takes_part, inverse;
    std::array<Lanes, kSteps> rows;  // of L: half of it as in the stencil, then what those reach from
  };
  void add_block(const LaplacianStencil& stencil, const std::vector<std::uint8_t>& active,
                 const std::vector<double>& weight, int x, int y);

  std::size_t pixels_, pitch_;
  std::vector<Block> blocks_;
  std::array<std::ptrdiff_t, kSteps> reach_{};  // in the grid
  std::vector<float> grid_;  // the picture with a margin, so that every neighbour is somewhere
};

HeldSystem::HeldSystem(const LaplacianStencil& stencil, const std::vector<std::uint8_t>& active,
                       const std::vector<double>& weight)
    : pixels_(stencil.pixels()), pitch_(static_cast<std::size_t>(stencil.width) + 2 * kReach + kLanes) {
  grid_.assign(pitch_ * static_cast<std::size_t>(stencil.height + 2 * kReach), 0.f);
  for (int k = 1; k < kHalf; ++k) {
    const auto [dx, dy] = LaplacianStencil::step(k);
    reach_[k] = static_cast<std::ptrdiff_t>(pitch_) * dy + dx;
    reach_[kHalf - 1 + k] = -reach_[k];
  }
  const auto for_blocks = [&](auto visit) {
    for (int y = 0; y < stencil.height; ++y)
      for (int x = 0; x < stencil.width;)
        if (active[static_cast<std::size_t>(y) * stencil.width + x])
          visit(x, y), x += kLanes;
        else
          ++x;
  };
  std::size_t count = 0;
  for_blocks([&](int, int) { ++count; });
  blocks_.reserve(count);
  for_blocks([&](int x, int y) { add_block(stencil, active, weight, x, y); });
}

void HeldSystem::add_block(const LaplacianStencil& stencil, const std::vector<std::uint8_t>& active,
                           const std::vector<double>& weight, int x, int y) {
  const int w = stencil.width, h = stencil.height;
  Block& block = blocks_.emplace_back();
  block.pixel = static_cast<std::size_t>(y) * w + x;
  block.at = pitch_ * static_cast<std::size_t>(y + kReach) + static_cast<std::size_t>(x + kReach);
  for (int l = 0; l < std::min(kLanes, w - x); ++l) {
    const std::size_t p = block.pixel + l;
    if (!active[p]) continue;
    const double diagonal = stencil.planes[0][p] + weight[p];
    block.takes_part[l] = 1;
    block.rows[0][l] = static_cast<float>(diagonal);
    block.inverse[l] = static_cast<float>(1 / diagonal);
    for (int k = 1; k < kHalf; ++k) {
      const auto [dx, dy] = LaplacianStencil::step(k);
      const int to = x + l + dx, from = x + l - dx;
      if (to >= 0 && to < w && y + dy < h) block.rows[k][l] = static_cast<float>(stencil.planes[k][p]);
      if (from >= 0 && from < w && y >= dy)
        block.rows[kHalf - 1 + k][l] =
            static_cast<float>(stencil.planes[k][p - static_cast<std::size_t>(dy) * w - dx]);
    }
  }
}

void HeldSystem::multiply(const Vector& in, Vector& out) {
  // Blocks of a row do not overlap: what takes no part stays 0.
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    std::copy_n(in[b].data(), kLanes, grid_.data() + blocks_[b].at);
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Block& block = blocks_[b];
    Lanes sum{};
    for (int k = 0; k < kSteps; ++k) {
      const float* near = grid_.data() + block.at + reach_[k];
      for (int l = 0; l < kLanes; ++l) sum[l] += block.rows[k][l] * near[l];
    }
    out[b] = sum;
  }
}

void HeldSystem::precondition(const Vector& in, Vector& out) const {
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    for (int l = 0; l < kLanes; ++l) out[b][l] = blocks_[b].inverse[l] * in[b][l];
}

Vector HeldSystem::packed(const std::vector<double>& picture) const {
  Vector out(blocks_.size(), Lanes{});
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    for (int l = 0; l < kLanes; ++l)
      if (blocks_[b].takes_part[l] != 0) out[b][l] = static_cast<float>(picture[blocks_[b].pixel + l]);
  return out;
}

std::vector<double> HeldSystem::picture_of(const Vector& numbers) const {
  std::vector<double> out(pixels_, 0.0);
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    for (int l = 0; l < kLanes; ++l)
      if (blocks_[b].takes_part[l] != 0) out[blocks_[b].pixel + l] = static_cast<double>(numbers[b][l]);
  return out;
}

// to = a * to + b * other
void combine(float a, Vector& to, float b, const Vector& other) {
  for (std::size_t i = 0; i < to.size(); ++i)
    for (int l = 0; l < kLanes; ++l) to[i][l] = a * to[i][l] + b * other[i][l];
}

std::optional<std::vector<double>> solve(const LaplacianStencil& stencil,
                                         const std::vector<std::uint8_t>& active,
                                         const std::vector<double>& weight,
                                         const std::vector<double>& value) {
  std::vector<double> pulls(active.size(), 0.0);
  std::size_t unknowns = 0;
  for (std::size_t p = 0; p < active.size(); ++p) {
    if (!active[p]) continue;
    if (!(weight[p] >= kHeld)) return std::nullopt;
    pulls[p] = weight[p] * value[p];
    ++unknowns;
  }
  HeldSystem system(stencil, active, weight);
  Vector x = system.packed(value), residual = system.packed(pulls);  // begins with what pixels are held to
  Vector scaled(x.size(), Lanes{}), product = scaled;
  system.multiply(x, product);
  combine(1, residual, -1, product);
  system.precondition(residual, scaled);
  Vector direction = scaled;
  double left = dot(residual, scaled);
  const double enough = kResidual * kResidual * static_cast<double>(unknowns);
  for (int pass = 0; left > enough; ++pass) {
    if (pass == kMostPasses) return std::nullopt;
    system.multiply(direction, product);
    const float step = static_cast<float>(left / dot(direction, product));
    combine(1, x, step, direction);
    combine(1, residual, -step, product);
    system.precondition(residual, scaled);
    const double next = dot(residual, scaled);
    combine(static_cast<float>(next / left), direction, 1, scaled);
    left = next;
  }
  if (!std::isfinite(left)) return std::nullopt;
  return system.picture_of(x);
}

void table(HeldSolver* out) { *out = {hwy::TargetName(HWY_TARGET), solve}; }

}  // namespace
}  // namespace floatstage::matting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::matting {

HWY_EXPORT(table);

namespace {

void fill_table(HeldSolver* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

std::optional<std::vector<double>> solve_held_band(const LaplacianStencil& stencil,
                                                   const std::vector<std::uint8_t>& active,
                                                   const std::vector<double>& weight,
                                                   const std::vector<double>& value) {
  static const HeldSolver best = native_kernels(fill_table);
  return best.solve(stencil, active, weight, value);
}

std::vector<HeldSolver> all_held_solvers() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::matting
#endif
