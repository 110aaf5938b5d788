#pragma once

#include <vector>

#include <Eigen/Core>

namespace floatstage {

/// The outline of the subject in one picture: simple, disjoint polygons in the photograph's own pixels
/// (corner convention), the subject to the right of every edge as one walks it on the screen (y down), so
/// that outer polygons have positive shoelace area and holes negative.
struct Silhouette {
  std::vector<Eigen::Vector2d> points;  ///< all polygons one after the other, px
  std::vector<int>
      starts;  ///< polygon k is points[starts[k]] … points[starts[k + 1] - 1]; one more than polygons
  /// What lies outside the picture is not known, so it counts as inside: set when the subject is cut by the
  /// border of the picture or is not in it at all. The polygons then bound the *background* that was seen.
  bool beyond_counts = false;

  int polygons() const { return starts.empty() ? 0 : static_cast<int>(starts.size()) - 1; }
  bool empty() const { return points.empty(); }
  void clear() {
    points.clear();
    starts.clear();
    beyond_counts = false;
  }
};

}  // namespace floatstage
