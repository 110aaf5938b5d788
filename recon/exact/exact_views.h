#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "recon/exact/exact_integer.h"

namespace floatstage::recon {

/// One silhouette as the exact engine sees it: a cone of planes through the camera's centre. From here on the
/// rays are the data, pixels never return. Ray k starts contour edge k, which ends at ray next[k].
struct ConeView {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> rays;  ///< world; z = 1 in the camera's frame
  std::vector<int> next, prev, loop;  ///< per ray
  bool beyond_counts = false;         ///< outside of all polygons is inside
  bool mandatory = false;             ///< cannot be outvoted: the sides of a volume

  void clear();
  /// Appends a closed polygon, interior on the side of ray(k) x ray(next).
  void add_loop(std::span<const Eigen::Vector3d> loop_rays) {
    add_loop(loop_rays.size(), [&](std::size_t k) { return loop_rays[k]; });
  }
  /// The same of `count` rays that ray_of(k) gives.
  template <class RayOf>
  void add_loop(std::size_t count, const RayOf& ray_of) {
    const int first = static_cast<int>(rays.size()), size = static_cast<int>(count);
    const int id = loop.empty() ? 0 : loop.back() + 1;
    for (int k = 0; k < size; ++k) {
      rays.push_back(ray_of(static_cast<std::size_t>(k)));
      next.push_back(first + (k + 1 < size ? k + 1 : 0));
      prev.push_back(first + (k > 0 ? k - 1 : size - 1));
      loop.push_back(id);
    }
  }
};

/// The same numbers on an integer grid, with which every predicate is exact.
struct GridViews {
  using Vector = std::array<std::int64_t, 3>;
  std::vector<Vector> centers;             ///< within 2^26 of their mean
  std::vector<std::vector<Vector>> rays;   ///< components within 2^28
  double ray_scale = 1, center_scale = 1;  ///< grid steps per unit
};

/// How far the data are moved before the arrangement is computed. Seed 0 moves nothing.
struct Perturbation {
  std::uint64_t seed = 0;
  double ray = 0;     ///< largest move of a ray, in units of its z (1e-4 px is 1e-4 / focal length)
  double center = 0;  ///< largest move of a centre, metres
};

/// Moves every ray and centre by a hash of its index and the seed.
void perturb(std::span<ConeView> views, const Perturbation& perturbation);

/// Rounds the views to the grid and overwrites them with the rounded numbers. False when the cameras are so
/// far apart compared to their distances that the grid cannot tell centres apart (1e-7 of the rig's size).
bool snap_to_grid(std::span<ConeView> views, GridViews& grid);

inline Int128 dot(const GridViews::Vector& a, const GridViews::Vector& b) {
  return static_cast<Int128>(a[0]) * b[0] + static_cast<Int128>(a[1]) * b[1] +
         static_cast<Int128>(a[2]) * b[2];
}
/// Components of operands within 2^28: the result stays within 2^57.
inline GridViews::Vector cross(const GridViews::Vector& a, const GridViews::Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline GridViews::Vector operator-(const GridViews::Vector& a, const GridViews::Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// A box as two cones: three of its planes meet in the lowest corner, the other three in the highest, and
/// seen from there the box fills a triangle. They work like any other view, so that the engine needs no
/// special case.
std::array<ConeView, 2> volume_views(const Eigen::AlignedBox3d& box);

}  // namespace floatstage::recon
