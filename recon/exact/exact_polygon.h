#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace floatstage::recon {

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
    bool is_hole;
  };
  struct Hole {
    std::size_t owner;
    double left;
    std::size_t ring;
    auto operator<=>(const Hole&) const = default;
  };
  void load(const Ring& ring);
  void find_rings(std::span<const std::int32_t> ends);
  bool contains(const Ring& ring, const Eigen::Vector2d& p) const;
  /// The smallest outline around a hole.
  std::size_t owner_of(const Ring& hole) const;
  /// By owner, from left to right: what lies to the left of a hole is connected before it.
  void sort_holes();
  void clip(std::vector<std::int32_t>& triangles);
  void bridge(const Ring& hole);
  bool is_ear(std::int32_t at) const;
  std::int32_t least_bad(std::int32_t from, std::int32_t remaining) const;

  std::span<const Eigen::Vector2d> points_;
  std::vector<Ring> rings_;
  std::vector<std::int32_t> loop_;
  std::vector<std::int32_t> merged_;
  std::vector<std::int32_t> next_, prev_;  ///< of the loop's corners that are left; next -1: cut off
  std::vector<std::int32_t> reflex_;
  std::vector<Hole> holes_;
};

}  // namespace floatstage::recon
