#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "recon/octree/octree_view.h"

namespace floatstage::recon {

/// Is this point in the hull: does no camera see it as background, and at least one as subject? (What no
/// camera sees has no witness; calling it solid would fill every dark corner of the search box.)
bool in_hull(std::span<const OctreeView> views, const Eigen::Vector3d& point);

/// A regular grid of points, centred on a box, one bit a point: inside the hull or not. The outermost layer
/// lies about half a voxel outside the box and is never inside, so every surface around the inside points is
/// closed.
class CarvedGrid {
 public:
  /// `resolution` voxels along the longest side of `box`.
  CarvedGrid(const Eigen::AlignedBox3d& box, int resolution);

  const Eigen::AlignedBox3d& box() const { return box_; }
  double voxel() const { return voxel_; }
  const Eigen::Vector3i& points() const { return points_; }  ///< grid points along x, y, z

  Eigen::Vector3d position(int x, int y, int z) const { return origin_ + voxel_ * Eigen::Vector3d(x, y, z); }
  bool inside(int x, int y, int z) const { return (row(y, z)[x >> 6] >> (x & 63)) & 1; }

  /// Points (·, y, z): bit x & 63 of word x >> 6. Bits beyond the last point are 0.
  const std::uint64_t* row(int y, int z) const { return bits_.data() + row_offset(y, z); }
  std::uint64_t* row(int y, int z) { return bits_.data() + row_offset(y, z); }
  std::size_t words_per_row() const { return words_; }

 private:
  std::size_t row_offset(int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(points_.y()) +
            static_cast<std::size_t>(y)) *
           words_;
  }
  Eigen::AlignedBox3d box_;
  double voxel_ = 0;
  Eigen::Vector3d origin_;  // of point (0, 0, 0)
  Eigen::Vector3i points_;
  std::size_t words_ = 0;
  std::vector<std::uint64_t> bits_;
};

/// Carves: the result equals in_hull() at every grid point inside the box, but whole octree nodes are judged
/// at once by the views' integral images, and only cameras that are still undecided are asked again further
/// down (Szeliski 1993's octree, with conservative bounds instead of a distance threshold). The same bits at
/// any thread count.
CarvedGrid carve(std::span<const OctreeView> views, const Eigen::AlignedBox3d& box, int resolution,
                 int threads);

/// The part of `box` that can hold hull, to within about 1/64 of it: what the views certainly carve is cut
/// away. Empty when nothing is left.
Eigen::AlignedBox3d shrink_to_hull(std::span<const OctreeView> views, const Eigen::AlignedBox3d& box);

}  // namespace floatstage::recon
