#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace floatstage::detail {

/// Points of a few dimensions, and which of them are nearest to a place: a tree of boxes over them, built
/// once, asked from any thread.
class NearestPoints {
 public:
  static constexpr int kMostDimensions = 40;
  static constexpr int kMostAsked = 8;

  struct Found {
    std::uint32_t index = 0;  ///< of the point as it was given
    float distance = 0;       ///< squared
  };

  NearestPoints() = default;
  /// `points`: `dimensions` numbers each, one point after the other; 1 to kMostDimensions.
  NearestPoints(const std::vector<float>& points, int dimensions);

  std::size_t count() const { return count_; }
  /// The `k` (1 to kMostAsked) nearest of the points to `place`, nearest first, into `found`; their number.
  /// `slack`: boxes are left out whose squared distance times 1 + slack is beyond the k-th found; 0: none is
  /// missed.
  int find(const float* place, int k, float slack, Found* found) const;

 private:
  struct Node {
    std::uint32_t first = 0, blocks = 0;  ///< of a leaf
    std::uint32_t right = 0;              ///< the left child follows its parent
    std::int32_t dimension = -1;          ///< -1: a leaf
    float low = 0, high = 0;              ///< the left child ends and the right one begins there
  };
  friend class NearestPointsBuilder;
  friend struct NearestPointsSearch;

  std::size_t count_ = 0;
  int dimensions_ = 0;
  std::vector<Node> nodes_;
  std::vector<float> blocks_;           ///< [block][dimension][lane]
  std::vector<std::uint32_t> indices_;  ///< [block][lane]
  std::vector<float> lowest_, highest_;
};

}  // namespace floatstage::detail
