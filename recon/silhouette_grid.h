#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/silhouette.h"

namespace floatstage::recon {

/// The edges of an outline in square cells, to find those that touch in time linear in their length. Edge e
/// goes from point e to next(e). Keeps its memory from one outline to the next.
class EdgeGrid {
 public:
  /// Sorts in an outline, which must outlive what is asked about it.
  void fill(const Silhouette& outline);

  /// Edges that come nearer than `gap` px to (or, with 0, touch) an edge that is not their neighbour. Sorted.
  void touching_edges(double gap, std::vector<int>& out) const;

  int next(int edge) const { return next_[edge]; }

  /// Whether `hit(point)` holds for any start point of an edge in the cells that overlap `box`.
  template <class Hit>
  bool any_point_in(const Eigen::AlignedBox2d& box, const Hit& hit) const {
    const auto [x0, y0] = cell_of(box.min());
    const auto [x1, y1] = cell_of(box.max());
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const std::size_t cell = static_cast<std::size_t>(y) * columns_ + x;
        for (int i = start_[cell]; i < start_[cell + 1]; ++i) {
          const int point = edges_[i];
          if (box.contains(points_[point]) && hit(point)) return true;
        }
      }
    }
    return false;
  }

 private:
  std::pair<int, int> cell_of(const Eigen::Vector2d& point) const;
  template <class Visit>
  void each_cell(int edge, const Visit& visit) const;

  const Eigen::Vector2d* points_ = nullptr;
  std::vector<int> next_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  double cell_ = 1;  // px
  int columns_ = 1, rows_ = 1;
  std::vector<int> fill_;
  std::vector<int> start_, edges_;  // cell c holds edges_[start_[c]] … edges_[start_[c + 1] - 1]
};

}  // namespace floatstage::recon
