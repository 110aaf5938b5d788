#include <cmath>
#include <set>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <Spectra/SymEigsShiftSolver.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "matting/spectral/grid_factor.h"
#include "matting/spectral/nested_dissection.h"
#include "matting/spectral/spectral_matting.h"
#include "tests/matting/hostile_pictures.h"
#include "tests/matting/small_scenes.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"

namespace floatstage::matting {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kShift = 1e-7;

// The slow exact way: Spectra's shift-invert Lanczos on Eigen's own sparse Cholesky factor.
class ShiftInvert {
 public:
  using Scalar = double;
  explicit ShiftInvert(const Eigen::SparseMatrix<double>& matrix) : matrix_(matrix) {}
  Eigen::Index rows() const { return matrix_.rows(); }
  Eigen::Index cols() const { return matrix_.cols(); }
  void set_shift(double sigma) {
    factor_.setShift(-sigma);
    factor_.compute(matrix_);
  }
  void perform_op(const double* in, double* out) const {
    Eigen::Map<VectorXd>(out, rows()) = factor_.solve(Eigen::Map<const VectorXd>(in, rows()));
  }

 private:
  const Eigen::SparseMatrix<double>& matrix_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

struct Reference {
  VectorXd values;
  MatrixXd vectors;
};

Reference spectra(const Image& picture, int count) {
  const auto laplacian = matting_laplacian(picture);
  EXPECT_THAT(laplacian, IsOk());
  ShiftInvert op(*laplacian);
  Spectra::SymEigsShiftSolver<ShiftInvert> solver(op, count, 3 * count, -kShift);
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, 1000, 1e-14, Spectra::SortRule::SmallestMagn);
  EXPECT_EQ(solver.info(), Spectra::CompInfo::Successful);
  Reference r{solver.eigenvalues(), solver.eigenvectors()};
  if (r.values(0) > r.values(count - 1)) {
    r.values.reverseInPlace();
    r.vectors = r.vectors.rowwise().reverse().eval();
  }
  return r;
}

// The largest sine between a vector of one space and the other space.
double sine_between(const MatrixXd& a, const MatrixXd& b) {
  const MatrixXd qa =
      Eigen::HouseholderQR<MatrixXd>(a).householderQ() * MatrixXd::Identity(a.rows(), a.cols());
  const MatrixXd qb =
      Eigen::HouseholderQR<MatrixXd>(b).householderQ() * MatrixXd::Identity(b.rows(), b.cols());
  return (qa - qb * (qb.transpose() * qa)).jacobiSvd().singularValues()(0);
}

double measured_residual(const Image& picture, const EigenPairs& pairs, int count) {
  const auto laplacian = matting_laplacian(picture);
  double worst = 0;
  for (int i = 0; i < count; ++i) {
    const VectorXd v = pairs.vectors.col(i).cast<double>();
    worst = std::max(worst, (*laplacian * v - pairs.values(i) * v).norm());
  }
  return worst;
}

EigenPairs solve(const Image& picture, const SpectralOptions& options = {},
                 const EigenPairs* previous = nullptr) {
  auto solver = EigenSolver::create(picture.width, picture.height, options);
  EXPECT_THAT(solver, IsOk());
  auto pairs = solver->solve(picture, previous);
  EXPECT_THAT(pairs, IsOk());
  return pairs ? *pairs : EigenPairs{};
}

TEST(NestedDissection, EliminatesEveryPixelOnce) {
  for (const auto& [w, h] : {std::pair{1, 1}, {3, 40}, {37, 23}, {6, 6}, {64, 64}}) {
    const std::vector<int> order = nested_dissection(w, h);
    EXPECT_EQ(order.size(), static_cast<std::size_t>(w * h));
    EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), order.size());
    EXPECT_EQ(*std::min_element(order.begin(), order.end()), 0);
  }
}

TEST(NestedDissection, KeepsTheFactorSmall) {
  const auto factor = GridFactor::create(180, 120);
  ASSERT_THAT(factor, IsOk());
  EXPECT_LT(factor->nonzeros(), 180u * 120 * 140);  // row by row it would be 180 * 120 * 240
}

TEST(GridFactor, SolvesWhatItFactored) {
  const Image picture = disc_picture(50, 31).rgb;
  LaplacianStencil stencil;
  build_stencil(picture, 1e-7, {}, stencil);
  auto factor = GridFactor::create(50, 31);
  ASSERT_THAT(factor, IsOk());
  ASSERT_THAT(factor->factor(stencil, 0.01), IsOk());
  const MatrixXd right = MatrixXd::Random(50 * 31, 35);
  MatrixXd solution(50 * 31, 35);
  ASSERT_THAT(factor->solve(right.data(), 35, solution.data()), IsOk());
  const auto laplacian = matting_laplacian(picture);
  MatrixXd back(50 * 31, 35), in_pixels(50 * 31, 35);
  for (int i = 0; i < 50 * 31; ++i) in_pixels.row(factor->order()[i]) = solution.row(i);
  in_pixels = *laplacian * in_pixels + 0.01 * in_pixels;
  for (int i = 0; i < 50 * 31; ++i) back.row(i) = in_pixels.row(factor->order()[i]);
  EXPECT_LT((back - right).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(GridFactor, RefusesWhatIsNotPositiveDefinite) {
  LaplacianStencil stencil;
  build_stencil(disc_picture(20, 20).rgb, 1e-7, {}, stencil);
  auto factor = GridFactor::create(20, 20);
  ASSERT_THAT(factor, IsOk());
  EXPECT_THAT(factor->factor(stencil, -0.01), FailsWith(ErrorCode::Unsupported, "not positive definite"));
  EXPECT_THAT(factor->factor(stencil, 0.01), IsOk()) << "and goes on with the next";
}

TEST(EigenSolver, AgreesWithSpectraWhenAskedForEverything) {
  const Image picture = disc_picture(120, 80, 0, 3).rgb;
  const EigenPairs pairs = solve(picture, {.krylov_block = 25, .krylov_steps = 12, .tolerance = 0});
  const Reference reference = spectra(picture, 50);
  EXPECT_NEAR(pairs.values(0), 0, 1e-12);
  for (int i = 1; i < 50; ++i)
    EXPECT_NEAR(pairs.values(i) / reference.values(i), 1, 1e-8) << "eigenvalue " << i;
  EXPECT_LT(sine_between(pairs.vectors.leftCols(25).cast<double>(), reference.vectors.leftCols(25)), 1e-6);
}

TEST(EigenSolver, AgreesWithSpectraAfterTenStepsOnAFrameOfAClip) {
  const Image frame =
      make_clip(studio_cutout(1), green_cloth(120, 80, 1), {.width = 120, .height = 80, .frames = 1})
          .frames[0];
  const EigenPairs pairs = solve(frame, {.krylov_block = 25, .krylov_steps = 10, .tolerance = 0});
  const Reference reference = spectra(frame, 50);
  for (int i = 1; i < 50; ++i)
    EXPECT_NEAR(pairs.values(i) / reference.values(i), 1, 1e-8) << "eigenvalue " << i;
}

TEST(EigenSolver, StopsAtTheToleranceAndSaysHowFarItGot) {
  const Image picture = disc_picture(120, 80, 0, 3).rgb;
  const EigenPairs coarse = solve(picture, {.tolerance = 1e-4}),
                   fine = solve(picture, {.krylov_steps = 20, .tolerance = 1e-6});
  EXPECT_LE(coarse.residual, 1e-4);
  EXPECT_LE(fine.residual, 1e-6);
  EXPECT_LT(fine.residual, coarse.residual);
  EXPECT_NEAR(measured_residual(picture, coarse, 50) / coarse.residual, 1, 0.05);
  EXPECT_EQ(coarse.values.size(), 60);
}

TEST(EigenSolver, StartsTheNextFrameFromThePrevious) {
  const Image first = disc_picture(120, 80, 0, 2).rgb, second = disc_picture(120, 80, 1.5, 2).rgb;
  const EigenPairs previous = solve(first);
  const EigenPairs warm = solve(second, {}, &previous), longer = solve(second, {.warm_steps = 4}, &previous);
  const EigenPairs exact = solve(second, {.krylov_block = 25, .krylov_steps = 12, .tolerance = 0});
  EXPECT_LT(sine_between(warm.vectors.leftCols(25).cast<double>(), exact.vectors.leftCols(28).cast<double>()),
            0.05);
  EXPECT_LT(longer.residual, warm.residual);
  EXPECT_NEAR(measured_residual(second, warm, 50) / warm.residual, 1, 0.05);
}

TEST(EigenSolver, FactorsEveryFrameOfSaturatedSkyAndFlatGreen) {
  auto solver = EigenSolver::create(120, 80);
  ASSERT_THAT(solver, IsOk());
  for (const auto clip : {saturated_sky, flat_green}) {
    EigenPairs previous;
    for (int frame = 0; frame < 8; ++frame) {
      auto pairs = solver->solve(clip(120, 80, frame), &previous);
      ASSERT_THAT(pairs, IsOk()) << "frame " << frame;
      EXPECT_TRUE(pairs->vectors.allFinite() && pairs->values.allFinite());
      EXPECT_LT(pairs->values(0), 1e-9);
      previous = std::move(*pairs);
    }
  }
  EXPECT_THAT(solver->solve(one_colour_line(120, 80)), IsOk());
}

TEST(EigenSolver, GivesTheSameBytesOnEveryThread) {
  const Image picture = disc_picture(60, 50).rgb;
  const EigenPairs alone = solve(picture);
  std::vector<EigenPairs> together(4);
  parallel_for(4, 2, [&](std::size_t i) { together[i] = solve(picture); });
  for (const EigenPairs& pairs : together) {
    EXPECT_EQ((pairs.vectors - alone.vectors).cwiseAbs().maxCoeff(), 0);
    EXPECT_EQ((pairs.values - alone.values).cwiseAbs().maxCoeff(), 0);
  }
}

TEST(EigenSolver, SaysWhatItCannotDo) {
  EXPECT_THAT(EigenSolver::create(8, 8), FailsWith(ErrorCode::InvalidArgument, "too small"));
  EXPECT_THAT(EigenSolver::create(-5, 100), FailsWith(ErrorCode::InvalidArgument, "too small"));
  EXPECT_THAT(EigenSolver::create(9000, 9000), FailsWith(ErrorCode::InvalidArgument, "too large"));
  EXPECT_THAT(EigenSolver::create(90, 90, {.components = 1}),
              FailsWith(ErrorCode::InvalidArgument, "components"));
  EXPECT_THAT(EigenSolver::create(90, 90, {.krylov_steps = 3}),
              FailsWith(ErrorCode::InvalidArgument, "Krylov"));
  auto solver = EigenSolver::create(40, 30);
  ASSERT_THAT(solver, IsOk());
  EXPECT_THAT(solver->solve(Image(40, 30, 3, 77)), FailsWith(ErrorCode::BadData, "one colour"));
  EXPECT_THAT(solver->solve(disc_picture(41, 30).rgb), FailsWith(ErrorCode::InvalidArgument, "41x30"));
  const EigenPairs other = solve(disc_picture(50, 30).rgb);
  EXPECT_THAT(solver->solve(disc_picture(40, 30).rgb, &other),
              FailsWith(ErrorCode::InvalidArgument, "50x30"));
}

}  // namespace
}  // namespace floatstage::matting
