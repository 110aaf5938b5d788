// Laplace's equation on a picture with any set of known pixels: multigrid (W. Briggs, V. Henson, S.
// McCormick, "A Multigrid Tutorial", SIAM 2000) on cell-centred grids. A coarse cell is known when one of its
// four is, so that a correction never moves what is known; cells near it are left to the smoothing (ADR
// 0218).

#include "detail/harmonic_fill.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace floatstage::detail {
namespace {

constexpr int kMostCycles = 30, kSweeps = 2, kCoarsest = 4;

struct Grid {
  int width = 0, height = 0;
  std::vector<std::uint8_t> fixed;
  std::vector<Light> u, f;  // neighbours' sum - 4 u = f where not fixed; empty: 0 (the finest grid)
  std::vector<Light> step;  // a correction; zero where fixed

  Grid(int w, int h, std::vector<std::uint8_t> known, std::vector<Light> values)
      : width(w), height(h), fixed(std::move(known)), u(std::move(values)), step(size(), Light{}) {}
  Grid(int w, int h) : width(w), height(h), fixed(size()), u(size()), f(size()), step(size()) {}
  std::size_t size() const { return static_cast<std::size_t>(width) * height; }
  const Light& force(std::size_t i) const {
    static constexpr Light kNone{};
    return f.empty() ? kNone : f[i];
  }
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};

// Calls visit(place, left, right, up, down) for the free cells of a row whose x + y has the parity 0 or 1, or
// any (-1); beyond the edge lies the cell itself.
template <class Visit>
void each_free_of_row(const Grid& g, int y, int parity, const Visit& visit) {
  const std::size_t row = g.at(0, y), up = g.at(0, std::max(y - 1, 0)),
                    down = g.at(0, std::min(y + 1, g.height - 1));
  const int step = parity < 0 ? 1 : 2, first = parity < 0 ? 0 : (y + parity) & 1;
  for (int x = first; x < g.width; x += step) {
    const auto c = static_cast<std::size_t>(x);
    if (g.fixed[row + c] == 0)
      visit(row + c, row + (x > 0 ? c - 1 : c), row + (x + 1 < g.width ? c + 1 : c), up + c, down + c);
  }
}

template <class Visit>
void each_free(const Grid& g, const Visit& visit) {
  for (int y = 0; y < g.height; ++y) each_free_of_row(g, y, -1, visit);
}

// Gauss and Seidel, red and black. Every half sweep follows the one before a row behind it, so that the grid
// goes through the cache once for all of them; what a cell sees is the same as in whole sweeps.
void smooth(Grid& g, int sweeps) {
  const auto relax = [&](std::size_t i, std::size_t l, std::size_t r, std::size_t a, std::size_t b) {
    const Light& f = g.force(i);
    for (std::size_t k = 0; k < 4; ++k)
      g.u[i][k] = 0.25F * (g.u[l][k] + g.u[r][k] + g.u[a][k] + g.u[b][k] - f[k]);
  };
  const int halves = 2 * sweeps;
  for (int front = 0; front < g.height + halves - 1; ++front)
    for (int half = std::max(0, front - g.height + 1); half <= std::min(halves - 1, front); ++half)
      each_free_of_row(g, front - half, half & 1, relax);
}

// The coarse values at the fine free cells, bilinearly.
void prolong(const Grid& coarse, const Grid& fine, std::vector<Light>& to) {
  for (int y = 0; y < fine.height; ++y) {
    const int j = y / 2, other = std::clamp(y % 2 == 0 ? j - 1 : j + 1, 0, coarse.height - 1);
    const Light *near = &coarse.u[coarse.at(0, j)], *far = &coarse.u[coarse.at(0, other)];
    for (int x = 0; x < fine.width; ++x) {
      const std::size_t at = fine.at(x, y);
      if (fine.fixed[at] != 0) continue;
      const int i = x / 2, side = std::clamp(x % 2 == 0 ? i - 1 : i + 1, 0, coarse.width - 1);
      for (std::size_t k = 0; k < 4; ++k)
        to[at][k] = 0.5625F * near[i][k] + 0.1875F * (near[side][k] + far[i][k]) + 0.0625F * far[side][k];
    }
  }
}

// Goes along the step as far as the energy falls: coarse boundaries lie beside the fine ones, so that
// corrections are too long or too short near them.
float take_step(Grid& g) {
  double gain[4] = {}, cost[4] = {};
  each_free(g, [&](std::size_t i, std::size_t l, std::size_t r, std::size_t a, std::size_t b) {
    const Light& f = g.force(i);
    for (std::size_t k = 0; k < 4; ++k) {
      const float e = g.step[i][k];
      const float residual = g.u[l][k] + g.u[r][k] + g.u[a][k] + g.u[b][k] - 4 * g.u[i][k] - f[k];
      const float bend = 4 * e - g.step[l][k] - g.step[r][k] - g.step[a][k] - g.step[b][k];
      gain[k] += static_cast<double>(e * residual);
      cost[k] += static_cast<double>(e * bend);
    }
  });
  Light length{};
  for (std::size_t k = 0; k < 4; ++k)
    length[k] = cost[k] > 0 ? static_cast<float>(std::clamp(gain[k] / cost[k], 0.0, 2.0)) : 0;
  float most = 0;
  each_free(g, [&](std::size_t i, auto...) {
    for (std::size_t k = 0; k < 4; ++k) {
      const float move = length[k] * g.step[i][k];
      g.u[i][k] += move;
      most = std::max(most, std::abs(move));
    }
  });
  return most;
}

void restrict_residual(const Grid& fine, Grid& coarse) {
  std::fill(coarse.u.begin(), coarse.u.end(), Light{});
  std::fill(coarse.f.begin(), coarse.f.end(), Light{});
  const auto w = static_cast<std::size_t>(fine.width);
  each_free(fine, [&](std::size_t i, std::size_t l, std::size_t r, std::size_t a, std::size_t b) {
    Light& to = coarse.f[coarse.at(static_cast<int>(i % w) / 2, static_cast<int>(i / w) / 2)];
    const Light& f = fine.force(i);
    for (std::size_t k = 0; k < 4; ++k)
      to[k] += f[k] - (fine.u[l][k] + fine.u[r][k] + fine.u[a][k] + fine.u[b][k] - 4 * fine.u[i][k]);
  });
}

// By how much it moved a value at most, smoothing left out.
float cycle(std::vector<Grid>& grids, std::size_t level) {
  if (level + 1 == grids.size()) {
    smooth(grids[level], 16);
    return 0;
  }
  smooth(grids[level], kSweeps);
  restrict_residual(grids[level], grids[level + 1]);
  cycle(grids, level + 1);
  prolong(grids[level + 1], grids[level], grids[level].step);
  const float most = take_step(grids[level]);
  smooth(grids[level], kSweeps);
  return most;
}

// Half as large; known is what has a known cell, with their mean.
Grid coarser(const Grid& fine) {
  Grid coarse((fine.width + 1) / 2, (fine.height + 1) / 2);
  std::vector<float> known(coarse.size(), 0);
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      if (fine.fixed[fine.at(x, y)] == 0) continue;
      const std::size_t to = coarse.at(x / 2, y / 2);
      for (std::size_t k = 0; k < 4; ++k) coarse.u[to][k] += fine.u[fine.at(x, y)][k];
      known[to] += 1;
      coarse.fixed[to] = 1;
    }
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i] > 0)
      for (float& v : coarse.u[i]) v /= known[i];
  return coarse;
}

}  // namespace

int fill_harmonically(LightPicture& picture, const std::vector<std::uint8_t>& fixed, float tolerance) {
  FLOATSTAGE_CHECK(fixed.size() == picture.pixels.size(), "one mark a pixel");
  for (std::size_t i = 0; i < fixed.size(); ++i)
    if (fixed[i] == 0) picture.pixels[i] = {};
  if (std::all_of(fixed.begin(), fixed.end(), [](auto f) { return f == 0; })) return 0;
  std::vector<Grid> grids;
  grids.emplace_back(picture.width, picture.height, fixed, std::move(picture.pixels));
  while (std::min(grids.back().width, grids.back().height) > kCoarsest)
    grids.push_back(coarser(grids.back()));
  smooth(grids.back(), 32);
  for (std::size_t level = grids.size() - 1; level-- > 0;) {
    prolong(grids[level + 1], grids[level], grids[level].u);
    if (level == 0) break;
    // The coarser levels are needed for their values only until here: a cycle uses them for corrections.
    cycle(grids, level);
  }
  int cycles = 0;
  for (float change = 1; change > tolerance && cycles < kMostCycles; ++cycles) change = cycle(grids, 0);
  picture.pixels = std::move(grids[0].u);
  return cycles;
}

}  // namespace floatstage::detail
