// Method:  k-means: seeds by k-means++, then Lloyd's iteration
// Paper:   D. Arthur, S. Vassilvitskii, "k-means++: the advantages of careful seeding", 2007
// Differs: one seeded generator, the best of some restarts; an empty
//          centre moves to the farthest point
// ADR:     none; docs/algorithms/spectral-matting.md

#include "matting/spectral/k_means.h"

#include <limits>

namespace floatstage::matting {
namespace {

constexpr int kRounds = 40;

using Eigen::Index;
using Eigen::MatrixXf;
using Eigen::VectorXf;

struct Nearest {
  std::vector<int> labels;
  VectorXf distances;  // squared
};

Nearest nearest(const MatrixXf& features, const MatrixXf& centres) {
  const Index n = features.cols();
  Nearest found{std::vector<int>(static_cast<std::size_t>(n)), VectorXf(n)};
  VectorXf distances(centres.cols());
  for (Index p = 0; p < n; ++p) {
    distances = (centres.colwise() - features.col(p)).colwise().squaredNorm();
    Index best = 0;
    found.distances(p) = distances.minCoeff(&best);
    found.labels[static_cast<std::size_t>(p)] = static_cast<int>(best);
  }
  return found;
}

// Each next seed is a point drawn with the probability of its squared distance to the seeds before it.
MatrixXf seeds(const MatrixXf& features, int clusters, Random& random) {
  const Index n = features.cols();
  MatrixXf centres(features.rows(), clusters);
  centres.col(0) = features.col(static_cast<Index>(random.uniform() * static_cast<double>(n)));
  VectorXf distances = VectorXf::Constant(n, std::numeric_limits<float>::max());
  for (int c = 1; c < clusters; ++c) {
    distances =
        distances.cwiseMin((features.colwise() - centres.col(c - 1)).colwise().squaredNorm().transpose());
    double rest = random.uniform() * distances.cast<double>().sum();
    Index chosen = 0;
    while (chosen + 1 < n && (rest -= distances(chosen)) > 0) ++chosen;
    centres.col(c) = features.col(chosen);
  }
  return centres;
}

}  // namespace

std::vector<int> nearest_centres(const MatrixXf& features, const MatrixXf& centres) {
  return nearest(features, centres).labels;
}

Clusters refine_clusters(const MatrixXf& features, MatrixXf centres, int rounds) {
  Clusters result{std::move(centres), {}, 0};
  const Index clusters = result.centres.cols();
  for (int round = 0;; ++round) {
    Nearest found = nearest(features, result.centres);
    const bool settled = found.labels == result.labels;
    result.labels = std::move(found.labels);
    result.error = found.distances.cast<double>().sum();
    if (settled || round == rounds) return result;
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(features.rows(), clusters);
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(clusters);
    for (Index p = 0; p < features.cols(); ++p) {
      const int label = result.labels[static_cast<std::size_t>(p)];
      sums.col(label) += features.col(p).cast<double>();
      counts(label) += 1;
    }
    for (Index c = 0; c < clusters; ++c) {
      if (counts(c) > 0) {
        result.centres.col(c) = (sums.col(c) / counts(c)).cast<float>();
        continue;
      }
      Index farthest = 0;
      found.distances.maxCoeff(&farthest);
      found.distances(farthest) = 0;
      result.centres.col(c) = features.col(farthest);
    }
  }
}

Clusters k_means(const MatrixXf& features, int clusters, int restarts, Random& random) {
  Clusters best;
  for (int i = 0; i < restarts; ++i) {
    Clusters found = refine_clusters(features, seeds(features, clusters, random), kRounds);
    if (i == 0 || found.error < best.error) best = std::move(found);
  }
  return best;
}

}  // namespace floatstage::matting
