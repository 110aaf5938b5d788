#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "recon/exact/exact_views.h"

namespace floatstage::recon {

/// A ray of one view passes through (the double wedge of) a contour edge of another view.
struct RayHit {
  std::int32_t edge;  ///< of the other view
  std::int32_t ray;   ///< of this view
  double w;           ///< 1/depth along the ray; negative behind the camera, where nothing is real
};

/// Everything about rays of view i against contour edges of view j (an ordered pair).
///
/// All planes through both centres form a pencil; every ray lies in one half-plane of it, at an angle phi
/// about the baseline. A ray of i meets an edge of j where the edge's arc of phi contains the ray's phi.
/// Within that half-plane the edge's plane is w = slope . d for a ray direction d: affine, without any
/// division by angles.
struct PairTable {
  /// Where the inside of j lies on one ray: nowhere below `low`, nowhere above `high`.
  struct Bound {
    double low, high;
  };
  struct FaceHit {  ///< a hit again, in the order in which faces read them
    double w;
    std::int32_t ray, index;  ///< into hits
  };
  std::vector<Eigen::Vector3d> slope;  ///< per edge of j: n / (n . (C_j - C_i)), so w = slope . d
  std::vector<std::uint8_t>
      upper;                 ///< per edge of j: 1 when the inside of j is at smaller w (an upper bound)
  std::vector<RayHit> hits;  ///< sorted by ray, then edge
  std::vector<std::int32_t> ray_start;   ///< ray r owns hits[ray_start[r]] … hits[ray_start[r + 1] - 1]
  std::vector<Bound> bounds;             ///< per ray
  std::vector<std::int32_t> face_start;  ///< edge f owns face_hits[face_start[f]] …, by ray
  std::vector<FaceHit> face_hits;
  int top = 0;                ///< 1 when C_i, where w is infinite, is inside the silhouette of j
  std::int32_t first_id = 0;  ///< number of the first hit among the hits of all pairs

  int hits_on(int ray) const { return ray_start[ray + 1] - ray_start[ray]; }
  /// Whether all between the ray's bounds is inside: it has no other hits.
  bool is_interval(int ray) const {
    const Bound& bound = bounds[ray];
    return hits_on(ray) == std::isfinite(bound.low) + std::isfinite(bound.high);
  }
};

/// Rays of both views of an unordered pair, seen along the baseline.
struct AxisTable {
  std::vector<Eigen::Vector2d> low, high;  ///< rays of the view with the lower, the higher index
  std::vector<double> low_key, high_key;   ///< monotone in phi, in [-2, 2]
  std::vector<std::int32_t> bin_start, bin_edges, first_bin, last_bin, found;  ///< scratch
};

class PairTables {
 public:
  /// Builds all V(V-1) tables. `grid` not null: every sign is exact, and `tie()` tells whether a predicate
  /// was zero. False, and no tables, when the outlines cross so often that a pair has more hits than
  /// most_hits().
  bool build(std::span<const ConeView> views, const GridViews* grid, int threads);

  /// Hits of one ordered pair of views: an equal share of four million, but always eight for each ray. People
  /// have two or three. Bounds the memory (32 bytes a hit) and the time of a frame.
  static std::size_t most_hits(std::size_t views, std::size_t rays) {
    return std::max<std::size_t>(4'000'000 / (views * (views - 1)), 8 * rays);
  }

  const PairTable& of(int i, int j) const { return pairs_[static_cast<std::size_t>(i) * views_ + j]; }
  const AxisTable& axis(int i, int j) const {
    return axes_[static_cast<std::size_t>(i < j ? i : j) * views_ + (i < j ? j : i)];
  }
  const RayHit& hit(std::int32_t id, int i, int j) const { return of(i, j).hits[id - of(i, j).first_id]; }
  std::int32_t hit_count() const { return hit_count_; }
  bool tie() const { return tie_; }

 private:
  void build_axis(std::span<const ConeView> views, const GridViews* grid, int i, int j, bool& tie);
  void find_hits(std::span<const ConeView> views, const GridViews* grid, AxisTable& axis, int i, int j,
                 bool& tie);

  std::size_t views_ = 0;
  std::vector<std::vector<Eigen::Vector3d>> normals_;  ///< per view and edge
  std::vector<PairTable> pairs_;
  std::vector<AxisTable> axes_;
  std::vector<std::uint8_t> ties_, too_many_;
  std::int32_t hit_count_ = 0;
  bool tie_ = false;
};

}  // namespace floatstage::recon
