#pragma once

#include <span>
#include <vector>

#include "recon/exact/exact_pairs.h"

namespace floatstage::recon {

/// How votes are counted: a point is hull when the weights of the views that contain it reach `needed`. A
/// mandatory view weighs as much as all others together, so that it cannot be outvoted.
struct Votes {
  int needed = 0;
  bool strict = true;       ///< all views have to agree
  int ordinary = 0;         ///< how many of the views that can be outvoted have to agree
  std::vector<int> weight;  ///< per view

  void set(std::span<const ConeView> views, int votes);
  /// Whether a view's boundary is the hull's where the other views that contain it weigh `others`.
  bool decides(int view, int others) const { return others < needed && others + weight[view] >= needed; }
};

/// A stretch of a ray that is an edge of the hull: the ray's own view is at its boundary there, and `votes -
/// 1` other views contain it. `low` and `high` number the hits at its ends; high is kApex where the stretch
/// reaches the camera.
struct RayInterval {
  static constexpr std::int32_t kApex = -1;
  std::int32_t low, high;
  double w_low, w_high;
};

/// Finds the stretch in which enough views can be inside, from where each of them can.
class VoteWindow {
 public:
  using Bound = PairTable::Bound;
  void clear(const Bound& all);
  void add(const Bound& bound, bool mandatory);
  /// For the boundary of a view; empty (low > high) when there are too few views.
  Bound find(const Votes& votes, bool own_is_mandatory);

 private:
  Bound all_{};
  std::vector<double> lows_, highs_;
};

struct RayCrossing {
  double w;
  std::int32_t id;
  std::int32_t edge;
  std::int16_t view;
  std::int16_t change;  ///< of the number of views that contain the ray, as w grows
};

/// What one view's rays need; kept from frame to frame.
struct RayScratch {
  std::vector<PairTable::Bound> windows;
  std::vector<RayCrossing> crossings;
  VoteWindow vote_window;
  bool tie = false, unbounded = false;
};

struct RayIntervals {
  std::vector<std::vector<RayInterval>> of_view;  ///< sorted by ray, then w
  std::vector<std::vector<std::int32_t>> start;   ///< per view: ray r owns of_view[v][start[v][r]] …
  bool unbounded = false;                         ///< some stretch does not end before infinity
  bool tie = false;                               ///< an exact comparison was zero
  std::vector<RayScratch> scratch;                ///< per view
};

void find_ray_intervals(std::span<const ConeView> views, const PairTables& pairs, const GridViews* grid,
                        const Votes& votes, int threads, RayIntervals& out);

}  // namespace floatstage::recon
