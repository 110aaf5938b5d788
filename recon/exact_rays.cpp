#include "recon/exact_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace floatstage {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Crossing {
  double w;
  std::int32_t id;
  std::int32_t edge;
  std::int16_t view;
  std::int16_t change;  ///< of the number of views that contain the ray, as w grows
};

/// Order of two hits on one ray; with a grid, decided by integers where doubles are not sure.
class HitOrder {
 public:
  HitOrder(std::span<const ConeView> views, const GridViews* grid, int view, int ray, bool& tie)
      : views_(views), grid_(grid), view_(view), ray_(ray), tie_(tie) {}

  bool operator()(const Crossing& a, const Crossing& b) const {
    if (!grid_ || std::abs(a.w - b.w) > 1e-14 * (std::abs(a.w) + std::abs(b.w))) return a.w < b.w;
    if (a.id == b.id) return false;
    const auto [above_a, below_a] = fraction(a);
    const auto [above_b, below_b] = fraction(b);
    const int sign = (Wide(above_a) * Wide(below_b) - Wide(above_b) * Wide(below_a)).sign();
    tie_ |= sign == 0;
    return sign * sign_of(below_a) * sign_of(below_b) < 0;
  }

 private:
  std::pair<Int128, Int128> fraction(const Crossing& c) const {
    const auto& rays = grid_->rays[c.view];
    const GridViews::Vector n = cross(rays[c.edge], rays[views_[c.view].next[c.edge]]);
    return {dot(n, grid_->rays[view_][ray_]), dot(n, grid_->centers[c.view] - grid_->centers[view_])};
  }

  std::span<const ConeView> views_;
  const GridViews* grid_;
  int view_, ray_;
  bool& tie_;
};

struct Scratch {
  std::vector<Crossing> crossings;
};

/// Gathers the hits that can matter and the number of views that contain the ray before the first of them.
int gather(const PairTables& pairs, int i, int ray, int views, const Votes& votes,
           std::vector<Crossing>& out) {
  // In a strict hull only the stretch between the last entry and the first exit matters.
  double window_low = 0, window_high = kInfinity;
  if (votes.strict) {
    for (int j = 0; j < views; ++j) {
      if (j == i) continue;
      const PairTable& pair = pairs.of(i, j);
      double low = kInfinity, high = 0;
      int state = pair.top;  // at w = 0, once all hits are counted
      for (int h = pair.ray_start[ray]; h < pair.ray_start[ray + 1]; ++h) {
        const RayHit& hit = pair.hits[h];
        if (hit.w <= 0) continue;
        low = std::min(low, hit.w);
        high = std::max(high, hit.w);
        state += pair.upper[hit.edge] ? 1 : -1;
      }
      window_low = std::max(window_low, state > 0 ? 0 : low);
      window_high = std::min(window_high, pair.top ? kInfinity : high);
    }
    window_low *= 1 - 1e-9;
    window_high *= 1 + 1e-9;
  }
  out.clear();
  if (window_low > window_high) return -1;
  int inside = 0;
  for (int j = 0; j < views; ++j) {
    if (j == i) continue;
    const PairTable& pair = pairs.of(i, j);
    int state = pair.top;
    for (int h = pair.ray_start[ray]; h < pair.ray_start[ray + 1]; ++h) {
      const RayHit& hit = pair.hits[h];
      if (hit.w <= 0 || hit.w < window_low) continue;
      const int change = pair.upper[hit.edge] ? -1 : 1;
      state -= change;
      if (hit.w > window_high) continue;
      out.push_back({hit.w, pair.first_id + h, hit.edge, static_cast<std::int16_t>(j),
                     static_cast<std::int16_t>(change)});
    }
    if (state > 0) inside += votes.weight[j];
    if (votes.strict && state <= 0 && pair.ray_start[ray] == pair.ray_start[ray + 1]) return -1;
  }
  return inside;
}

}  // namespace

Votes Votes::of(std::span<const ConeView> views, int votes) {
  const auto is_mandatory = [](const ConeView& view) { return view.mandatory; };
  const int mandatory = static_cast<int>(std::count_if(views.begin(), views.end(), is_mandatory));
  const int others = static_cast<int>(views.size()) - mandatory;
  Votes out;
  out.ordinary = votes > 0 ? std::min(votes, others) : others;
  out.strict = out.ordinary == others;
  out.needed = out.ordinary + mandatory * (others + 1);
  for (const ConeView& view : views) out.weight.push_back(view.mandatory ? others + 1 : 1);
  return out;
}

void find_ray_intervals(std::span<const ConeView> views, const PairTables& pairs, const GridViews* grid,
                        const Votes& votes, int threads, RayIntervals& out) {
  const int count = static_cast<int>(views.size());
  out.of_view.resize(views.size());
  out.start.resize(views.size());
  std::vector<std::uint8_t> unbounded(views.size(), 0), ties(views.size(), 0);
  parallel_for(views.size(), threads, [&](std::size_t v) {
    const int i = static_cast<int>(v), rays = static_cast<int>(views[v].rays.size());
    std::vector<RayInterval>& intervals = out.of_view[v];
    std::vector<std::int32_t>& start = out.start[v];
    intervals.clear();
    start.resize(static_cast<std::size_t>(rays) + 1);
    Scratch scratch;
    for (int ray = 0; ray < rays; ++ray) {
      start[ray] = static_cast<std::int32_t>(intervals.size());
      int inside = gather(pairs, i, ray, count, votes, scratch.crossings);
      if (inside < 0) continue;
      bool tie = false;
      std::sort(scratch.crossings.begin(), scratch.crossings.end(), HitOrder(views, grid, i, ray, tie));
      ties[v] |= tie;
      const Crossing* open = nullptr;
      bool is_open = votes.decides(i, inside);
      if (is_open) unbounded[v] = 1;
      for (const Crossing& crossing : scratch.crossings) {
        inside += crossing.change * votes.weight[crossing.view];
        const bool now = votes.decides(i, inside);
        if (now && !is_open) open = &crossing;
        if (!now && is_open && open) intervals.push_back({open->id, crossing.id, open->w, crossing.w});
        is_open = now;
      }
      if (is_open && open) intervals.push_back({open->id, RayInterval::kApex, open->w, kInfinity});
    }
    start[rays] = static_cast<std::int32_t>(intervals.size());
  });
  out.unbounded = std::any_of(unbounded.begin(), unbounded.end(), [](std::uint8_t u) { return u != 0; });
  out.tie = std::any_of(ties.begin(), ties.end(), [](std::uint8_t t) { return t != 0; });
}

}  // namespace floatstage
