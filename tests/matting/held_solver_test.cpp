#include "matting/held_solver.h"

#include <cmath>

#include <Eigen/SparseCholesky>

#include "core/random.h"
#include "matting/closed_form.h"
#include "tests/matting/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

// A band around the edge of a disc, its key a hard one, as refine_matte() has it.
struct Band {
  LaplacianStencil stencil;
  std::vector<std::uint8_t> active;
  std::vector<double> weight, value;
};

Band band_of(const Scene& scene, double hold) {
  Band band;
  const Image alpha = to_image(truth(scene));
  Image key = alpha, known = trimap_around(alpha, {.margin = 6, .soft_from = 1, .soft_to = 254});
  for (std::uint8_t& v : key.pixels) v = v >= 128 ? 255 : 0;
  for (std::uint8_t& v : known.pixels) v = v == 128 ? 0 : 255;
  build_stencil(photograph(scene), 1e-7, known, band.stencil);
  for (std::size_t p = 0; p < key.pixels.size(); ++p) {
    band.active.push_back(known.pixels[p] == 0 || band.stencil.planes[0][p] > 0);
    band.weight.push_back(known.pixels[p] ? 100 : hold);
    band.value.push_back(key.pixels[p] / 255.0);
  }
  return band;
}

// By a factor of the whole matrix, which no other code of the stage has a part in.
std::vector<double> exact_solution(const Band& band) {
  const LaplacianStencil& s = band.stencil;
  const int n = static_cast<int>(s.pixels());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  for (int p = 0; p < n; ++p) {
    const auto at = static_cast<std::size_t>(p);
    if (!band.active[at]) {
      entries.emplace_back(p, p, 1.0);
      continue;
    }
    right[p] = band.weight[at] * band.value[at];
    entries.emplace_back(p, p, s.planes[0][at] + band.weight[at]);
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) {
        const int x = p % s.width + dx, y = p / s.width + dy;
        if ((dx == 0 && dy == 0) || x < 0 || x >= s.width || y < 0 || y >= s.height) continue;
        const int other = y * s.width + x;
        if (band.active[static_cast<std::size_t>(other)])
          entries.emplace_back(p, other, s.at(p % s.width, p / s.width, dx, dy));
      }
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd x = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
  return {x.data(), x.data() + n};
}

class HeldBand : public testing::TestWithParam<double> {};

TEST_P(HeldBand, IsSolvedToAQuarterOfAStepOfEightBits) {
  for (const double noise : {0.0, 3.0}) {
    const Band band = band_of({.noise = noise}, GetParam());
    const std::optional<std::vector<double>> solved =
        solve_held_band(band.stencil, band.active, band.weight, band.value);
    ASSERT_TRUE(solved);
    const std::vector<double> exact = exact_solution(band);
    double worst = 0;
    for (std::size_t p = 0; p < exact.size(); ++p) worst = std::max(worst, std::abs((*solved)[p] - exact[p]));
    EXPECT_LE(worst, 1e-3) << "noise " << noise;
  }
}

INSTANTIATE_TEST_SUITE_P(Holds, HeldBand, testing::Values(0.01, 0.05, 1.0, 100.0));

TEST(HeldBand, IsLeftToTheFactorWhereAPixelIsHardlyHeld) {
  Band band = band_of({}, 0.05);
  for (std::size_t p = 0; p < band.active.size(); ++p)
    if (band.active[p] && band.weight[p] < 1) {
      band.weight[p] = 1e-4;
      break;
    }
  EXPECT_FALSE(solve_held_band(band.stencil, band.active, band.weight, band.value));
}

TEST(HeldBand, IsEmptyWhereNothingTakesPart) {
  Band band = band_of({}, 0.05);
  band.active.assign(band.active.size(), 0);
  const std::optional<std::vector<double>> solved =
      solve_held_band(band.stencil, band.active, band.weight, band.value);
  ASSERT_TRUE(solved);
  EXPECT_THAT(*solved, testing::Each(0.0));
}

TEST(HeldBand, HasTheSameBytesOnEveryInstructionSet) {
  const Band band = band_of({.noise = 2}, 0.05);
  const std::vector<HeldSolver> all = all_held_solvers();
  const auto solve = [&](const HeldSolver& by) {
    return *by.solve(band.stencil, band.active, band.weight, band.value);
  };
  for (const HeldSolver& one : all) EXPECT_EQ(solve(one), solve(all.front())) << one.name;
}

TEST(LaplacianStencil, HasTheSameBytesOnEveryInstructionSet) {
  const Image picture = photograph({.noise = 2});
  LaplacianStencil expected;
  build_stencil(picture, 1e-7, {}, expected);
  for (const StencilKernels& one : all_stencil_kernels()) {
    LaplacianStencil made = expected;
    for (std::vector<double>& plane : made.planes) plane.assign(plane.size(), 0.0);
    one.add_windows(picture, 1e-7, {}, made);
    one.reset_diagonal(made);
    EXPECT_EQ(made.planes, expected.planes) << one.name;
  }
}

TEST(HeldBand, IsTheSameEachTime) {
  const Band band = band_of({.noise = 2}, 0.05);
  const auto solve = [&] { return *solve_held_band(band.stencil, band.active, band.weight, band.value); };
  EXPECT_EQ(solve(), solve());
}

}  // namespace
}  // namespace floatstage::matting
