#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace floatstage {

/// Cuts polygons with holes into triangles by ear clipping; for the faces of the hull, which have four to six
/// corners. Keeps its scratch memory.
class PolygonCutter {
 public:
  /// `points` holds the polygons one after the other; polygon p ends before ends[p]. Outer polygons run
  /// clockwise, holes counter-clockwise (y up). Appends triples of point indices, clockwise, n + 2 holes - 2
  /// of them for each outer polygon: always, also when the polygons are degenerate, so that a closed surface
  /// stays closed.
  void cut(std::span<const Eigen::Vector2d> points, std::span<const std::int32_t> ends,
           std::vector<std::int32_t>& triangles);

 private:
  struct Ring {
    std::int32_t begin, end;
    double area;  ///< positive for clockwise
  };
  void clip(std::vector<std::int32_t>& triangles);
  void bridge(const Ring& hole);
  bool is_ear(std::size_t before, std::size_t at, std::size_t after) const;

  std::span<const Eigen::Vector2d> points_;
  std::vector<Ring> rings_;
  std::vector<std::int32_t> loop_;
  std::vector<std::int32_t> merged_;
};

}  // namespace floatstage
