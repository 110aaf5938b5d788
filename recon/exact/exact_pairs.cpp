// Method:  rays of one view against edges of another, in the pencil of planes through both centres
// Paper:   W. Matusik, C. Buehler, L. McMillan, "Polyhedral visual hulls for real-time rendering", 2001:
//          edge bins
// Differs: angles about the baseline and triple products, not slopes about an epipole: no special case
// ADR:     0070, 0071

#include "recon/exact/exact_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "core/parallel.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double cross2(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Monotone in the angle, without trigonometry.
double diamond_angle(const Vector2d& v) {
  const double sum = std::abs(v.x()) + std::abs(v.y());
  if (!(sum > 0)) return 0;
  const double y = v.y() / sum;
  return v.x() >= 0 ? y : (v.y() >= 0 ? 2 - y : -2 - y);
}

Vector3d mean_of(const std::vector<Vector3d>& rays) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& ray : rays) sum += ray;
  return sum;
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnsure = 1e-12;  // relative: far above the rounding of a triple product in doubles

// Edges of a view in bins of phi, so that a ray is tried against few of them. The memory is the axis table's.
class EdgeBins {
 public:
  EdgeBins(std::span<const double> keys, std::span<const std::int32_t> next, AxisTable& axis) : axis_(axis) {
    choose_width(keys, next);
    axis.first_bin.resize(keys.size());
    axis.last_bin.resize(keys.size());
    axis.bin_start.assign(static_cast<std::size_t>(bins_) + 2, 0);
    const int edges = static_cast<int>(keys.size());
    for (int f = 0; f < edges; ++f) {
      set_range(f, keys[f], keys[next[f]]);
      each_bin(f, [&](int bin) { ++axis_.bin_start[bin + 2]; });
    }
    for (int bin = 0; bin <= bins_; ++bin) axis.bin_start[bin + 1] += axis.bin_start[bin];
    axis.bin_edges.resize(axis.bin_start[bins_ + 1]);
    for (int f = 0; f < edges; ++f)
      each_bin(f, [&](int bin) { axis_.bin_edges[axis_.bin_start[bin + 1]++] = f; });
  }

  // Those whose arc may hold an angle.
  std::span<const std::int32_t> around(double key) const {
    const int bin = bin_of(key, 0);
    const std::int32_t first = axis_.bin_start[bin], end = axis_.bin_start[bin + 1];
    return {axis_.bin_edges.data() + first, static_cast<std::size_t>(end - first)};
  }

 private:
  // As many bins as edges; fewer where so many edges lie over each other that each would fill hundreds of
  // bins.
  void choose_width(std::span<const double> keys, std::span<const std::int32_t> next) {
    double most = -2, length = 0;
    for (const double key : keys) {
      least_ = std::min(least_, key);
      most = std::max(most, key);
    }
    for (std::size_t f = 0; f < keys.size(); ++f) length += std::abs(keys[f] - keys[next[f]]);
    const double layers = most > least_ ? length / (most - least_) : 1,
                 edges = static_cast<double>(keys.size());
    bins_ = std::max(16, static_cast<int>(edges * std::min(1.0, 64 / std::max(layers, 1.0))));
    scale_ = most > least_ ? bins_ / (most - least_) : 0;
  }

  int bin_of(double key, double margin) const {
    return std::clamp(static_cast<int>((key - least_) * scale_ + margin), 0, bins_ - 1);
  }

  // First and last bin of an edge; first > last means over the cut: [0, last] and [first, bins).
  void set_range(int f, double p, double q) {
    int first = bin_of(std::min(p, q), -1e-6), last = bin_of(std::max(p, q), 1e-6);
    if (std::abs(p - q) > 2) {
      std::swap(first, last);
      if (first <= last) {  // the whole circle
        first = 0;
        last = bins_ - 1;
      }
    }
    axis_.first_bin[f] = first;
    axis_.last_bin[f] = last;
  }

  template <class Visit>
  void each_bin(int f, const Visit& visit) const {
    const int first = axis_.first_bin[f], last = axis_.last_bin[f];
    if (first <= last) {
      for (int bin = first; bin <= last; ++bin) visit(bin);
    } else {
      for (int bin = 0; bin <= last; ++bin) visit(bin);
      for (int bin = first; bin < bins_; ++bin) visit(bin);
    }
  }

  AxisTable& axis_;
  double least_ = 2, scale_ = 0;
  int bins_ = 0;
};

// The hits of rays of view i on edges of view j.
class HitSearch {
 public:
  HitSearch(std::span<const ConeView> views, const GridViews* grid, AxisTable& axis, int i, int j,
            PairTable& pair)
      : grid_(grid),
        axis_(axis),
        pair_(pair),
        from_(views[i]),
        to_(views[j]),
        rays_(i < j ? axis.low : axis.high),
        ends_(i < j ? axis.high : axis.low),
        i_(i),
        j_(j),
        forward_(i < j) {}

  // False when there are more than `most`.
  bool run(std::size_t most) {
    const EdgeBins bins(forward_ ? axis_.high_key : axis_.low_key, to_.next, axis_);
    const std::vector<double>& key = forward_ ? axis_.low_key : axis_.high_key;
    const int count = static_cast<int>(rays_.size());
    pair_.hits.clear();
    pair_.bounds.resize(rays_.size());
    pair_.ray_start.resize(rays_.size() + 1);
    pair_.face_start.assign(ends_.size() + 1, 0);
    axis_.found.resize(ends_.size());
    for (int a = 0; a < count; ++a) {
      pair_.ray_start[a] = static_cast<std::int32_t>(pair_.hits.size());
      const std::span<const std::int32_t> met = edges_met(a, bins.around(key[a]));
      if (a == 0) begin_with(met);
      if (pair_.hits.size() + met.size() > most) return false;
      add_hits(a, met);
    }
    pair_.ray_start[count] = static_cast<std::int32_t>(pair_.hits.size());
    order_by_face();
    return true;
  }

  bool tie() const { return tie_; }

 private:
  // On which side of edge end p ray a is. Zero counts as "the higher view's ray is on the positive side", the
  // same for both directions of the pair.
  bool positive(int a, int p) {
    const double c = cross2(rays_[a], ends_[p]);
    if (grid_ && std::abs(c) < kUnsure * from_.rays[a].norm() * to_.rays[p].norm()) {
      const GridViews::Vector e =
          forward_ ? grid_->centers[j_] - grid_->centers[i_] : grid_->centers[i_] - grid_->centers[j_];
      const Int128 exact = dot(cross(grid_->rays[i_][a], grid_->rays[j_][p]), e);
      tie_ |= exact == 0;
      return exact > 0;
    }
    return forward_ ? c >= 0 : c > 0;
  }

  // Which of `near` hold the ray's angle: counted without a branch, for it is as good as random.
  std::span<const std::int32_t> edges_met(int a, std::span<const std::int32_t> near) {
    std::int32_t* const met = axis_.found.data();
    std::size_t found = 0;
    for (const std::int32_t f : near) {
      const bool ccw = (pair_.upper[f] != 0) == forward_;
      met[found] = f;
      found += static_cast<std::size_t>(positive(a, f) != ccw) &
               static_cast<std::size_t>(positive(a, to_.next[f]) == ccw);
    }
    return {met, found};
  }

  // The first ray tells whether the centre of i is inside the silhouette of j: upper minus lower bounds are
  // the same in every half-plane.
  void begin_with(std::span<const std::int32_t> met) {
    for (const std::int32_t f : met) net_ += pair_.upper[f] ? 1 : -1;
    pair_.top = net_ == 0 ? to_.beyond_counts : net_ < 0;
  }

  // 1/depth at which ray a passes through edge f's plane.
  double inverse_depth(int a, int f) {
    if (!grid_) return pair_.slope[f].dot(from_.rays[a]);
    const auto &p = grid_->rays[j_][f], &q = grid_->rays[j_][to_.next[f]];
    const GridViews::Vector n = cross(p, q);
    const Int128 above = dot(n, grid_->rays[i_][a]), below = dot(n, grid_->centers[j_] - grid_->centers[i_]);
    tie_ |= above == 0;
    return static_cast<double>(above) / static_cast<double>(below) * (grid_->center_scale / grid_->ray_scale);
  }

  void add_hits(int a, std::span<const std::int32_t> met) {
    PairTable::Bound bound{pair_.top + net_ > 0 ? -kInfinity : kInfinity, pair_.top ? kInfinity : -kInfinity};
    for (const std::int32_t f : met) {
      const double w = inverse_depth(a, f);
      pair_.hits.push_back({f, a, w});
      ++pair_.face_start[f + 1];
      if (pair_.upper[f]) {
        bound.high = std::max(bound.high, w);
      } else {
        bound.low = std::min(bound.low, w);
      }
    }
    pair_.bounds[a] = bound;
  }

  // The hits once more, sorted by edge, then ray.
  void order_by_face() {
    const int edges = static_cast<int>(ends_.size());
    for (int f = 0; f < edges; ++f) pair_.face_start[f + 1] += pair_.face_start[f];
    pair_.face_hits.resize(pair_.hits.size());
    for (std::size_t h = 0; h < pair_.hits.size(); ++h) {
      const RayHit& hit = pair_.hits[h];
      pair_.face_hits[pair_.face_start[hit.edge]++] = {hit.w, hit.ray, static_cast<std::int32_t>(h)};
    }
    for (int f = edges; f > 0; --f) pair_.face_start[f] = pair_.face_start[f - 1];
    pair_.face_start[0] = 0;
  }

  const GridViews* const grid_;
  AxisTable& axis_;
  PairTable& pair_;
  const ConeView &from_, &to_;
  const std::vector<Vector2d>&rays_, &ends_;
  const int i_, j_;
  const bool forward_;
  bool tie_ = false;
  int net_ = 0;
};

}  // namespace

bool PairTables::build(std::span<const ConeView> views, const GridViews* grid, int threads) {
  views_ = views.size();
  pairs_.resize(views_ * views_);
  axes_.resize(views_ * views_);
  const std::size_t count = views_ * (views_ - 1) / 2;
  ties_.assign(count, 0);
  too_many_.assign(views_ * views_, 0);
  normals_.resize(views_);
  for (std::size_t v = 0; v < views_; ++v) {
    const ConeView& view = views[v];
    normals_[v].resize(view.rays.size());
    for (std::size_t f = 0; f < view.rays.size(); ++f)
      normals_[v][f] = view.rays[f].cross(view.rays[view.next[f]]);
  }
  parallel_for(count, threads, [&](std::size_t k) {
    int i = 0;
    std::size_t rest = k;
    while (rest >= views_ - 1 - i) rest -= views_ - 1 - i++;
    bool tie = false;
    build_axis(views, grid, i, i + 1 + static_cast<int>(rest), tie);
    ties_[k] = tie;
  });
  if (std::any_of(too_many_.begin(), too_many_.end(), [](std::uint8_t t) { return t != 0; })) return false;
  tie_ = std::any_of(ties_.begin(), ties_.end(), [](std::uint8_t t) { return t != 0; });
  hit_count_ = 0;
  for (PairTable& pair : pairs_) {
    pair.first_id = hit_count_;
    hit_count_ += static_cast<std::int32_t>(pair.hits.size());
  }
  return true;
}

void PairTables::build_axis(std::span<const ConeView> views, const GridViews* grid, int i, int j, bool& tie) {
  AxisTable& axis = axes_[static_cast<std::size_t>(i) * views_ + j];
  const ConeView &low = views[i], &high = views[j];
  Vector3d baseline = high.center - low.center;
  if (grid) {
    const GridViews::Vector e = grid->centers[j] - grid->centers[i];
    baseline = Vector3d(static_cast<double>(e[0]), static_cast<double>(e[1]), static_cast<double>(e[2])) /
               grid->center_scale;
  }
  const Vector3d along = baseline.normalized();
  // phi = 0 where most rays are, so that few edges cross the cut of the angle at +-pi.
  Vector3d u = mean_of(low.rays) + mean_of(high.rays);
  u -= along * u.dot(along);
  if (!(u.norm() > 1e-9)) u = along.unitOrthogonal();
  u.normalize();
  const Vector3d v = along.cross(u);
  const auto flatten = [&](const std::vector<Vector3d>& rays, std::vector<Vector2d>& flat,
                           std::vector<double>& key) {
    flat.resize(rays.size());
    key.resize(rays.size());
    for (std::size_t r = 0; r < rays.size(); ++r) {
      flat[r] = {rays[r].dot(u), rays[r].dot(v)};
      key[r] = diamond_angle(flat[r]);
    }
  };
  flatten(low.rays, axis.low, axis.low_key);
  flatten(high.rays, axis.high, axis.high_key);

  const auto slopes = [&](int from, int to) {
    PairTable& pair = pairs_[static_cast<std::size_t>(from) * views_ + to];
    const ConeView& target = views[to];
    const Vector3d e = from < to ? baseline : Vector3d(-baseline);
    pair.slope.resize(target.rays.size());
    pair.upper.resize(target.rays.size());
    for (std::size_t f = 0; f < target.rays.size(); ++f) {
      const Vector3d& n = normals_[to][f];
      double d = n.dot(e);
      if (grid) {
        const auto &p = grid->rays[to][f], &q = grid->rays[to][target.next[f]];
        const Int128 exact = dot(cross(p, q), grid->centers[to] - grid->centers[from]);
        tie |= exact == 0;
        d = static_cast<double>(exact) / (grid->ray_scale * grid->ray_scale * grid->center_scale);
      }
      pair.slope[f] = n / d;
      pair.upper[f] = d > 0;
    }
  };
  slopes(i, j);
  slopes(j, i);
  find_hits(views, grid, axis, i, j, tie);
  find_hits(views, grid, axis, j, i, tie);
}

void PairTables::find_hits(std::span<const ConeView> views, const GridViews* grid, AxisTable& axis, int i,
                           int j, bool& tie) {
  const std::size_t pair = static_cast<std::size_t>(i) * views_ + j;
  HitSearch search(views, grid, axis, i, j, pairs_[pair]);
  too_many_[pair] = !search.run(most_hits(views_, views[i].rays.size()));
  tie |= search.tie();
}

}  // namespace floatstage::recon
