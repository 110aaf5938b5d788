#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "detail/synthesis/color_grid.h"

namespace floatstage::detail {

/// The 5 x 5 pixels around one, three colours each, in the few numbers that tell them apart: the first
/// principal components (thesis 4.4.2.4).
class Neighbourhoods {
 public:
  static constexpr int kReach = 2, kSide = 2 * kReach + 1, kLength = 3 * kSide * kSide;
  static constexpr int kMost = 32;  ///< components

  Neighbourhoods() = default;
  /// Learns the components from the pixels of `colors` that are marked in `usable` (of the same region), at
  /// most some twenty thousand, evenly chosen. Components whose variance is below `least` of the first's are
  /// left out. `mean_counts`: how much the mean colour of a neighbourhood counts, beside 1 for what differs
  /// from it.
  Neighbourhoods(const ColorGrid& colors, const Grid<std::uint8_t>& usable, float mean_counts = 1,
                 double least = 0.005);

  int dimensions() const { return dimensions_; }
  /// The components of the neighbourhood of a pixel: dimensions() numbers. Beyond the grid's border the
  /// border's pixels.
  void project(const ColorGrid& colors, int x, int y, float* out) const;

 private:
  int dimensions_ = 0;
  float mean_counts_ = 1;
  Eigen::Matrix<float, kLength, 1> mean_;
  Eigen::Matrix<float, Eigen::Dynamic, kLength, Eigen::ColMajor> basis_;
};

}  // namespace floatstage::detail
