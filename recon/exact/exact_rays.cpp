// Method:  where along each ray enough views agree: the hull's edges
//          along viewing rays, by counting bounds
// Paper:   J.-S. Franco, E. Boyer, "Exact polyhedral visual hulls", BMVC 2003: viewing edges
// Differs: m of n views may decide, and views that cannot be outvoted weigh as much as all others together
// ADR:     0070, 0072, 0074

#include "recon/exact/exact_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace floatstage::recon {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Order of two hits on one ray; with a grid, decided by integers where doubles are not sure.
class HitOrder {
 public:
  HitOrder(std::span<const ConeView> views, const GridViews* grid, int view, int ray, bool& tie)
      : views_(views), grid_(grid), view_(view), ray_(ray), tie_(tie) {}

  bool operator()(const RayCrossing& a, const RayCrossing& b) const {
    if (!grid_ || std::abs(a.w - b.w) > 1e-14 * (std::abs(a.w) + std::abs(b.w))) return a.w < b.w;
    if (a.id == b.id) return false;
    const auto [above_a, below_a] = fraction(a);
    const auto [above_b, below_b] = fraction(b);
    const int sign = (Wide(above_a) * Wide(below_b) - Wide(above_b) * Wide(below_a)).sign();
    tie_ |= sign == 0;
    return sign * sign_of(below_a) * sign_of(below_b) < 0;
  }

 private:
  std::pair<Int128, Int128> fraction(const RayCrossing& c) const {
    const auto& rays = grid_->rays[c.view];
    const GridViews::Vector n = cross(rays[c.edge], rays[views_[c.view].next[c.edge]]);
    return {dot(n, grid_->rays[view_][ray_]), dot(n, grid_->centers[c.view] - grid_->centers[view_])};
  }

  std::span<const ConeView> views_;
  const GridViews* grid_;
  int view_, ray_;
  bool& tie_;
};

/// The stretch of each ray of view i in which enough views can be inside, a little widened; empty (low >
/// high) where there is none. Only this matters.
void find_windows(const PairTables& pairs, int i, std::span<const ConeView> views, const Votes& votes,
                  RayScratch& scratch) {
  std::vector<PairTable::Bound>& windows = scratch.windows;
  windows.assign(views[i].rays.size(), {0, kInfinity});
  const int count = static_cast<int>(views.size());
  if (!votes.strict) {
    for (std::size_t ray = 0; ray < windows.size(); ++ray) {
      scratch.vote_window.clear({0, kInfinity});
      for (int j = 0; j < count; ++j) {
        if (j != i) scratch.vote_window.add(pairs.of(i, j).bounds[ray], views[j].mandatory);
      }
      windows[ray] = scratch.vote_window.find(votes, views[i].mandatory);
    }
  }
  for (int j = 0; j < count && votes.strict; ++j) {
    if (j == i) continue;
    const PairTable::Bound* bounds = pairs.of(i, j).bounds.data();
    for (std::size_t ray = 0; ray < windows.size(); ++ray) {
      windows[ray].low = std::max(windows[ray].low, bounds[ray].low);
      windows[ray].high = std::min(windows[ray].high, bounds[ray].high);
    }
  }
  for (PairTable::Bound& window : windows) {
    window.low *= 1 - 1e-9;
    window.high *= 1 + 1e-9;
  }
}

/// Gathers the hits that can matter and the weight of the views that contain the ray before the first of
/// them; -1 where there is no hull.
int gather(const PairTables& pairs, int i, int ray, int views, const PairTable::Bound& window,
           const Votes& votes, std::vector<RayCrossing>& out) {
  out.clear();
  if (window.low > window.high) return -1;
  int inside = 0;
  for (int j = 0; j < views; ++j) {
    if (j == i) continue;
    const PairTable& pair = pairs.of(i, j);
    const PairTable::Bound& bound = pair.bounds[ray];
    if (bound.low < window.low && bound.high > window.high && pair.is_interval(ray)) {
      inside += votes.weight[j];
      continue;
    }
    int state = pair.top;
    for (int h = pair.ray_start[ray]; h < pair.ray_start[ray + 1]; ++h) {
      const RayHit& hit = pair.hits[h];
      if (hit.w <= 0 || hit.w < window.low) continue;
      const int change = pair.upper[hit.edge] ? -1 : 1;
      state -= change;
      if (hit.w > window.high) continue;
      out.push_back({hit.w, pair.first_id + h, hit.edge, static_cast<std::int16_t>(j),
                     static_cast<std::int16_t>(change)});
    }
    if (state > 0) inside += votes.weight[j];
    if (votes.strict && state <= 0 && pair.hits_on(ray) == 0) return -1;
  }
  return inside;
}

}  // namespace

void Votes::set(std::span<const ConeView> views, int votes) {
  const auto is_mandatory = [](const ConeView& view) { return view.mandatory; };
  const int mandatory = static_cast<int>(std::count_if(views.begin(), views.end(), is_mandatory));
  const int others = static_cast<int>(views.size()) - mandatory;
  ordinary = votes > 0 ? std::min(votes, others) : others;
  strict = ordinary == others;
  needed = ordinary + mandatory * (others + 1);
  weight.clear();
  for (const ConeView& view : views) weight.push_back(view.mandatory ? others + 1 : 1);
}

void VoteWindow::clear(const Bound& all) {
  all_ = all;
  lows_.clear();
  highs_.clear();
}

void VoteWindow::add(const Bound& bound, bool mandatory) {
  if (mandatory) {
    all_ = {std::max(all_.low, bound.low), std::min(all_.high, bound.high)};
  } else {
    lows_.push_back(bound.low);
    highs_.push_back(-bound.high);
  }
}

VoteWindow::Bound VoteWindow::find(const Votes& votes, bool own_is_mandatory) {
  const int needed = votes.ordinary - (own_is_mandatory ? 0 : 1);
  if (needed > static_cast<int>(lows_.size())) return {kInfinity, -kInfinity};
  if (needed > 0) {
    std::nth_element(lows_.begin(), lows_.begin() + (needed - 1), lows_.end());
    std::nth_element(highs_.begin(), highs_.begin() + (needed - 1), highs_.end());
    all_ = {std::max(all_.low, lows_[needed - 1]), std::min(all_.high, -highs_[needed - 1])};
  }
  return all_;
}

void find_ray_intervals(std::span<const ConeView> views, const PairTables& pairs, const GridViews* grid,
                        const Votes& votes, int threads, RayIntervals& out) {
  const int count = static_cast<int>(views.size());
  out.of_view.resize(views.size());
  out.start.resize(views.size());
  out.scratch.resize(views.size());
  parallel_for(views.size(), threads, [&](std::size_t v) {
    const int i = static_cast<int>(v), rays = static_cast<int>(views[v].rays.size());
    std::vector<RayInterval>& intervals = out.of_view[v];
    std::vector<std::int32_t>& start = out.start[v];
    intervals.clear();
    bool any_tie = false, any_unbounded = false;
    start.resize(static_cast<std::size_t>(rays) + 1);
    RayScratch& scratch = out.scratch[v];
    find_windows(pairs, i, views, votes, scratch);
    for (int ray = 0; ray < rays; ++ray) {
      start[ray] = static_cast<std::int32_t>(intervals.size());
      int inside = gather(pairs, i, ray, count, scratch.windows[ray], votes, scratch.crossings);
      if (inside < 0) continue;
      bool tie = false;
      std::sort(scratch.crossings.begin(), scratch.crossings.end(), HitOrder(views, grid, i, ray, tie));
      any_tie |= tie;
      const RayCrossing* open = nullptr;
      bool is_open = votes.decides(i, inside);
      any_unbounded |= is_open;
      for (const RayCrossing& crossing : scratch.crossings) {
        inside += crossing.change * votes.weight[crossing.view];
        const bool now = votes.decides(i, inside);
        if (now && !is_open) open = &crossing;
        if (!now && is_open && open) intervals.push_back({open->id, crossing.id, open->w, crossing.w});
        is_open = now;
      }
      if (is_open && open) intervals.push_back({open->id, RayInterval::kApex, open->w, kInfinity});
    }
    start[rays] = static_cast<std::int32_t>(intervals.size());
    scratch.tie = any_tie;
    scratch.unbounded = any_unbounded;
  });
  out.unbounded = out.tie = false;
  for (const RayScratch& scratch : out.scratch) {
    out.unbounded |= scratch.unbounded;
    out.tie |= scratch.tie;
  }
}

}  // namespace floatstage::recon
