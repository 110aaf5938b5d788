// Method:  eigenvectors turned into matting components
// Paper:   A. Levin, A. Rav-Acha, D. Lischinski, "Spectral matting", PAMI 2008, section 3.2; thesis,
//          section 7.2
// Differs: component k continues component k of the frame before, so that a choice made once lasts
// ADR:     0093

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "core/text.h"
#include "matting/blas.h"
#include "matting/spectral/k_means.h"
#include "matting/spectral/sparse_components.h"
#include "matting/spectral/spectral_matting.h"

namespace floatstage::matting {
namespace {

constexpr int kClusterVectors = 20;  // eigenvectors, after the constant one, that k-means looks at
constexpr int kClusterStride = 2;    // every n-th pixel in x and y is clustered
constexpr int kFollowRounds = 10;    // Lloyd rounds from the previous frame's clusters
constexpr double kFlatValue = 1e-8;  // eigenvalues below: directions of the null space, all weighted alike

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;

// Every stride-th pixel in x and y, offset to the middle of its cell.
std::vector<Index> grid_of(int width, int height, int stride) {
  std::vector<Index> pixels;
  for (int y = stride / 2; y < height; y += stride)
    for (int x = stride / 2; x < width; x += stride) pixels.push_back(static_cast<Index>(y) * width + x);
  return pixels;
}

// dimensions x pixels: the vectors [first, first + count) at these pixels, each scaled.
MatrixXf gather(const MatrixXf& vectors, Index first, const Eigen::VectorXf& scale,
                const std::vector<Index>& pixels) {
  MatrixXf out(scale.size(), static_cast<Index>(pixels.size()));
  for (Index d = 0; d < scale.size(); ++d) {
    const auto column = vectors.col(first + d);
    for (Index i = 0; i < out.cols(); ++i) out(d, i) = scale(d) * column(pixels[static_cast<std::size_t>(i)]);
  }
  return out;
}

// Mean features of the pixels where each of the previous components is the largest. One that is nowhere the
// largest has no centre to start from: it gets a pixel's features, far from the others for want of company.
MatrixXf previous_centres(const MatrixXf& features, const std::vector<Index>& pixels,
                          const MattingComponents& previous) {
  MatrixXd sums = MatrixXd::Zero(features.rows(), previous.count());
  VectorXd counts = VectorXd::Zero(previous.count());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    Index label = 0;
    previous.alpha.row(pixels[i]).maxCoeff(&label);
    sums.col(label) += features.col(static_cast<Index>(i)).cast<double>();
    counts(label) += 1;
  }
  for (Index c = 0; c < sums.cols(); ++c)
    sums.col(c) = counts(c) > 0 ? VectorXd(sums.col(c) / counts(c)) : VectorXd::Constant(sums.rows(), 1e9);
  return sums.cast<float>();
}

}  // namespace

Result<MattingComponents> matting_components(const EigenPairs& pairs, const SpectralOptions& options,
                                             const MattingComponents* previous) {
  if (const auto good = options.check(); !good) return forward(good);
  const Index n = pairs.vectors.rows(), dimensions = options.eigenvectors;
  if (pairs.vectors.cols() < dimensions)
    return fail(ErrorCode::InvalidArgument,
                text("there are ", pairs.vectors.cols(), " eigenvectors; the options ask for ", dimensions));
  const bool follow = previous && !previous->empty();
  if (follow && (previous->width != pairs.width || previous->height != pairs.height ||
                 previous->count() != options.components))
    return fail(ErrorCode::InvalidArgument,
                text("the previous frame has ", previous->count(), " components of ", previous->width, "x",
                     previous->height, ", this one wants ", options.components, " of ", pairs.width, "x",
                     pairs.height));

  // The constant vector comes first and tells no two pixels apart.
  const Index used = std::min<Index>(kClusterVectors, dimensions - 1);
  const Eigen::VectorXf weights =
      pairs.values.segment(1, used).cwiseMax(kFlatValue).cwiseSqrt().cwiseInverse().cast<float>();
  const std::vector<Index> grid = grid_of(pairs.width, pairs.height, kClusterStride);
  const MatrixXf features = gather(pairs.vectors, 1, weights, grid);
  Random random(options.seed);
  const Clusters clusters =
      follow ? refine_clusters(features, previous_centres(features, grid, *previous), kFollowRounds)
             : k_means(features, options.components, options.clusterings, random);

  // The coefficients of each cluster's indicator, from the clustered pixels standing for their cells.
  const Eigen::VectorXf alike = Eigen::VectorXf::Ones(dimensions);
  const MatrixXf clustered = gather(pairs.vectors, 0, alike, grid);
  MatrixXd start = MatrixXd::Zero(dimensions, options.components);
  const double cell = static_cast<double>(n) / static_cast<double>(grid.size());
  for (std::size_t i = 0; i < grid.size(); ++i)
    start.col(clusters.labels[i]) += cell * clustered.col(static_cast<Index>(i)).cast<double>();
  const VectorXd ones = pairs.vectors.leftCols(dimensions).colwise().sum().transpose().cast<double>();

  const bool same_grid = options.newton_stride == kClusterStride;
  const MatrixXd y = sparse_components(
      same_grid ? clustered
                : gather(pairs.vectors, 0, alike, grid_of(pairs.width, pairs.height, options.newton_stride)),
      start, ones, {options.sparsity, options.newton_steps});
  MattingComponents result{pairs.width, pairs.height, MatrixXf(n, options.components)};
  product(pairs.vectors.leftCols(dimensions), y.cast<float>(), result.alpha);
  return result;
}

Image matte_of(const MattingComponents& components, const std::vector<bool>& chosen) {
  Image matte(components.width, components.height, 1);
  Eigen::VectorXf sum = Eigen::VectorXf::Zero(components.alpha.rows());
  for (std::size_t c = 0; c < chosen.size(); ++c)
    if (chosen[c]) sum += components.alpha.col(static_cast<Index>(c));
  for (std::size_t p = 0; p < matte.pixels.size(); ++p)
    matte.pixels[p] =
        static_cast<std::uint8_t>(std::lround(255 * std::clamp(sum(static_cast<Index>(p)), 0.0f, 1.0f)));
  return matte;
}

}  // namespace floatstage::matting
