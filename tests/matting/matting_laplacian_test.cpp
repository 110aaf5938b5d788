#include "matting/matting_laplacian.h"

#include <cmath>

#include <Eigen/Dense>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/matting/hostile_pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

Image random_picture(int width, int height, std::uint64_t seed) {
  Random random(seed);
  Image picture(width, height, 3);
  for (auto& byte : picture.pixels) byte = static_cast<std::uint8_t>(random.next() & 255);
  return picture;
}

// The definition, window by window, dense and in long double: eq. 12 of closed-form matting as it is printed.
Eigen::MatrixXd dense_reference(const Image& picture, double epsilon, const Image& known = {}) {
  using Real = long double;
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  const int n = picture.width * picture.height;
  Matrix laplacian = Matrix::Zero(n, n);
  for (int y = 1; y + 1 < picture.height; ++y) {
    for (int x = 1; x + 1 < picture.width; ++x) {
      Eigen::Matrix<Real, 9, 3> colours;
      int index[9], unknown = 0;
      for (int i = 0; i < 9; ++i) {
        const int px = x + i % 3 - 1, py = y + i / 3 - 1;
        index[i] = py * picture.width + px;
        unknown += known.empty() || *known.at(px, py) == 0;
        for (int c = 0; c < 3; ++c)
          colours(i, c) = picture.at(px, py)[picture.channels == 1 ? 0 : c] / Real(255);
      }
      if (unknown == 0) continue;
      const Eigen::Matrix<Real, 1, 3> mean = colours.colwise().mean();
      const Eigen::Matrix<Real, 9, 3> centred = colours.rowwise() - mean;
      Eigen::Matrix<Real, 3, 3> covariance = centred.transpose() * centred / 9;
      covariance.diagonal().array() += Real(epsilon) / 9;
      const Eigen::Matrix<Real, 9, 9> affinity = centred * covariance.fullPivLu().solve(centred.transpose());
      for (int i = 0; i < 9; ++i)
        for (int j = 0; j < 9; ++j)
          laplacian(index[i], index[j]) += (i == j ? 1 : 0) - (1 + affinity(i, j)) / 9;
    }
  }
  return laplacian.cast<double>();
}

TEST(MattingLaplacian, IsTheDefinitionOfClosedFormMatting) {
  for (const auto& [width, height] : {std::pair{3, 3}, {4, 3}, {9, 5}, {11, 12}, {19, 4}}) {
    const Image picture = random_picture(width, height, 7);
    for (const double epsilon : {1e-7, 1e-4}) {
      const auto laplacian = matting_laplacian(picture, {.epsilon = epsilon});
      ASSERT_THAT(laplacian, IsOk());
      EXPECT_LT((Eigen::MatrixXd(*laplacian) - dense_reference(picture, epsilon)).cwiseAbs().maxCoeff(),
                1e-11)
          << width << "x" << height << ", epsilon " << epsilon;
    }
  }
}

TEST(MattingLaplacian, TakesGreyAsThreeEqualChannels) {
  Image grey(8, 6, 1), rgb(8, 6, 3);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
    grey.pixels[i] = static_cast<std::uint8_t>(i * 37 % 251);
    for (int c = 0; c < 3; ++c) rgb.pixels[3 * i + c] = grey.pixels[i];
  }
  const auto a = matting_laplacian(grey), b = matting_laplacian(rgb);
  ASSERT_THAT(a, IsOk());
  ASSERT_THAT(b, IsOk());
  EXPECT_EQ((*a - *b).norm(), 0);
}

TEST(MattingLaplacian, IsSymmetricSortedAndSumsToZero) {
  const auto laplacian = matting_laplacian(random_picture(23, 17, 3));
  ASSERT_THAT(laplacian, IsOk());
  const Eigen::SparseMatrix<double> transposed = laplacian->transpose();
  EXPECT_EQ((*laplacian - transposed).norm(), 0);
  EXPECT_LT((*laplacian * Eigen::VectorXd::Ones(23 * 17)).cwiseAbs().maxCoeff(), 1e-14);
  for (int column = 0; column < laplacian->outerSize(); ++column) {
    int last = -1;
    for (Eigen::SparseMatrix<double>::InnerIterator entry(*laplacian, column); entry; ++entry) {
      EXPECT_GT(entry.row(), last);
      last = static_cast<int>(entry.row());
    }
  }
}

TEST(MattingLaplacian, LeavesOutWindowsThatAreAllKnown) {
  const Image picture = random_picture(14, 11, 9);
  Image known(14, 11, 1);
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 14; ++x) *known.at(x, y) = x < 6 || y > 8 ? 255 : 0;
  const auto laplacian = matting_laplacian(picture, {}, known);
  ASSERT_THAT(laplacian, IsOk());
  EXPECT_LT((Eigen::MatrixXd(*laplacian) - dense_reference(picture, 1e-7, known)).cwiseAbs().maxCoeff(),
            1e-11);
  const auto whole = matting_laplacian(picture);
  ASSERT_THAT(whole, IsOk());
  EXPECT_LT(laplacian->nonZeros(), whole->nonZeros() * 3 / 4);
}

TEST(MattingLaplacian, HasOnePatternForOneSize) {
  const auto busy = matting_laplacian(random_picture(12, 9, 1)),
             flat = matting_laplacian(Image(12, 9, 3, 40));
  ASSERT_THAT(busy, IsOk());
  ASSERT_THAT(flat, IsOk());
  ASSERT_EQ(busy->nonZeros(), flat->nonZeros());
  for (Eigen::Index i = 0; i < busy->nonZeros(); ++i)
    ASSERT_EQ(busy->innerIndexPtr()[i], flat->innerIndexPtr()[i]);
}

// The 3x3 picture has one window, so its Laplacian is one block. With an inverse of the covariance one block
// in a hundred of such pictures has an eigenvalue of -1e-3.
TEST(MattingLaplacian, IsPositiveSemidefiniteInEveryWindowOfSaturatedSkyAndFlatGreen) {
  double worst = 0;
  for (const Image& picture : {saturated_sky(96, 64, 0), flat_green(96, 64, 0), one_colour_line(96, 64)}) {
    for (int y = 0; y + 3 <= picture.height; ++y) {
      for (int x = 0; x + 3 <= picture.width; ++x) {
        Image window(3, 3, 3);
        for (int i = 0; i < 9; ++i) std::copy_n(picture.at(x + i % 3, y + i / 3), 3, window.at(i % 3, i / 3));
        const auto block = matting_laplacian(window);
        ASSERT_THAT(block, IsOk());
        const Eigen::Matrix<double, 9, 9> dense = Eigen::MatrixXd(*block);
        worst = std::min(
            worst, Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>>(dense, Eigen::EigenvaluesOnly)
                       .eigenvalues()(0));
      }
    }
  }
  EXPECT_GT(worst, -3e-15);
}

TEST(MattingLaplacian, SaysWhatDoesNotFit) {
  const Image picture = random_picture(8, 8, 1);
  EXPECT_THAT(matting_laplacian(Image(2, 9, 3)), FailsWith(ErrorCode::InvalidArgument, "2x9"));
  EXPECT_THAT(matting_laplacian(Image(9, 9, 4)), FailsWith(ErrorCode::InvalidArgument, "4 channels"));
  EXPECT_THAT(matting_laplacian({}), FailsWith(ErrorCode::InvalidArgument, "channels"));
  EXPECT_THAT(matting_laplacian(picture, {}, Image(8, 7, 1)), FailsWith(ErrorCode::InvalidArgument, "8x7"));
  EXPECT_THAT(matting_laplacian(picture, {.epsilon = 0}), FailsWith(ErrorCode::InvalidArgument, "epsilon"));
  EXPECT_THAT(matting_laplacian(picture, {.epsilon = NAN}), FailsWith(ErrorCode::InvalidArgument, "epsilon"));
}

}  // namespace
}  // namespace floatstage::matting
