#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/random.h"

// Private to the stage.
namespace floatstage::matting {

/// Points are columns: `features` is dimensions x points, centres dimensions x clusters.
struct Clusters {
  Eigen::MatrixXf centres;
  std::vector<int> labels;  ///< of the points
  double error = 0;         ///< sum of squared distances to the own centre
};

/// k-means++ seeds (Arthur, Vassilvitskii 2007) and Lloyd's iteration, `restarts` times; the best of them.
Clusters k_means(const Eigen::MatrixXf& features, int clusters, int restarts, Random& random);

/// Lloyd's iteration from given centres, at most `rounds` rounds. A centre without points moves to the point
/// that is farthest from its own.
Clusters refine_clusters(const Eigen::MatrixXf& features, Eigen::MatrixXf centres, int rounds);

/// The nearest centre of every column of `features`.
std::vector<int> nearest_centres(const Eigen::MatrixXf& features, const Eigen::MatrixXf& centres);

}  // namespace floatstage::matting
