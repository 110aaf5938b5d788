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
  PairTable& pair = pairs_[static_cast<std::size_t>(i) * views_ + j];
  const bool forward = i < j;
  const ConeView &from = views[i], &to = views[j];
  const auto &rays = forward ? axis.low : axis.high, &ends = forward ? axis.high : axis.low;
  const auto &ray_key = forward ? axis.low_key : axis.high_key,
             &end_key = forward ? axis.high_key : axis.low_key;
  const int edges = static_cast<int>(ends.size()), count = static_cast<int>(rays.size());

  // Edges of j in bins of phi.
  double least = 2, most = -2;
  for (const double key : end_key) {
    least = std::min(least, key);
    most = std::max(most, key);
  }
  // As many bins as edges; fewer where so many edges lie over each other that each would fill hundreds of
  // bins.
  double length = 0;
  for (int f = 0; f < edges; ++f) length += std::abs(end_key[f] - end_key[to.next[f]]);
  const double layers = most > least ? length / (most - least) : 1;
  const int bins = std::max(16, static_cast<int>(edges * std::min(1.0, 64 / std::max(layers, 1.0))));
  const double scale = most > least ? bins / (most - least) : 0;
  const auto bin_of = [&](double key, double margin) {
    return std::clamp(static_cast<int>((key - least) * scale + margin), 0, bins - 1);
  };
  // First and last bin of every edge; first > last means over the cut: [0, last] and [first, bins).
  axis.first_bin.resize(ends.size());
  axis.last_bin.resize(ends.size());
  axis.bin_start.assign(static_cast<std::size_t>(bins) + 2, 0);
  const auto each_bin = [&](int f, const auto& visit) {
    const int first = axis.first_bin[f], last = axis.last_bin[f];
    if (first <= last) {
      for (int bin = first; bin <= last; ++bin) visit(bin);
    } else {
      for (int bin = 0; bin <= last; ++bin) visit(bin);
      for (int bin = first; bin < bins; ++bin) visit(bin);
    }
  };
  for (int f = 0; f < edges; ++f) {
    const double p = end_key[f], q = end_key[to.next[f]];
    int first = bin_of(std::min(p, q), -1e-6), last = bin_of(std::max(p, q), 1e-6);
    if (std::abs(p - q) > 2) {
      std::swap(first, last);
      if (first <= last) {  // the whole circle
        first = 0;
        last = bins - 1;
      }
    }
    axis.first_bin[f] = first;
    axis.last_bin[f] = last;
    each_bin(f, [&](int bin) { ++axis.bin_start[bin + 2]; });
  }
  for (int bin = 0; bin <= bins; ++bin) axis.bin_start[bin + 1] += axis.bin_start[bin];
  axis.bin_edges.resize(axis.bin_start[bins + 1]);
  for (int f = 0; f < edges; ++f)
    each_bin(f, [&](int bin) { axis.bin_edges[axis.bin_start[bin + 1]++] = f; });

  // Zero counts as "the higher view's ray is on the positive side", the same for both directions of the pair.
  const auto positive = [&](int a, int p) {
    const double c = cross2(rays[a], ends[p]);
    if (grid && std::abs(c) < kUnsure * from.rays[a].norm() * to.rays[p].norm()) {
      const GridViews::Vector e =
          forward ? grid->centers[j] - grid->centers[i] : grid->centers[i] - grid->centers[j];
      const Int128 exact = dot(cross(grid->rays[i][a], grid->rays[j][p]), e);
      tie |= exact == 0;
      return exact > 0;
    }
    return forward ? c >= 0 : c > 0;
  };
  pair.hits.clear();
  pair.bounds.resize(rays.size());
  pair.ray_start.resize(static_cast<std::size_t>(count) + 1);
  pair.face_start.assign(static_cast<std::size_t>(edges) + 1, 0);
  axis.found.resize(ends.size());
  const std::size_t limit = most_hits(views_, rays.size());
  int net = 0;  // upper minus lower: the same in every half-plane
  for (int a = 0; a < count; ++a) {
    pair.ray_start[a] = static_cast<std::int32_t>(pair.hits.size());
    const int bin = bin_of(ray_key[a], 0);
    int found = 0;
    for (int at = axis.bin_start[bin]; at < axis.bin_start[bin + 1]; ++at) {
      const int f = axis.bin_edges[at];
      const bool ccw = (pair.upper[f] != 0) == forward;
      axis.found[found] = f;  // counted without a branch: which edges are met is as good as random
      found += static_cast<int>(positive(a, f) != ccw) & static_cast<int>(positive(a, to.next[f]) == ccw);
    }
    if (a == 0) {
      for (int k = 0; k < found; ++k) net += pair.upper[axis.found[k]] ? 1 : -1;
      pair.top = net == 0 ? to.beyond_counts : net < 0;
    }
    if (pair.hits.size() + static_cast<std::size_t>(found) > limit) {
      too_many_[static_cast<std::size_t>(i) * views_ + j] = 1;
      return;
    }
    PairTable::Bound bound{pair.top + net > 0 ? -kInfinity : kInfinity, pair.top ? kInfinity : -kInfinity};
    for (int k = 0; k < found; ++k) {
      const int f = axis.found[k];
      double w = pair.slope[f].dot(from.rays[a]);
      if (grid) {
        const auto &p = grid->rays[j][f], &q = grid->rays[j][to.next[f]];
        const GridViews::Vector n = cross(p, q);
        const Int128 above = dot(n, grid->rays[i][a]), below = dot(n, grid->centers[j] - grid->centers[i]);
        tie |= above == 0;
        w = static_cast<double>(above) / static_cast<double>(below) * (grid->center_scale / grid->ray_scale);
      }
      pair.hits.push_back({f, a, w});
      ++pair.face_start[f + 1];
      if (pair.upper[f]) {
        bound.high = std::max(bound.high, w);
      } else {
        bound.low = std::min(bound.low, w);
      }
    }
    pair.bounds[a] = bound;
  }
  pair.ray_start[count] = static_cast<std::int32_t>(pair.hits.size());

  for (int f = 0; f < edges; ++f) pair.face_start[f + 1] += pair.face_start[f];
  pair.face_hits.resize(pair.hits.size());
  for (std::size_t h = 0; h < pair.hits.size(); ++h) {
    const RayHit& hit = pair.hits[h];
    pair.face_hits[pair.face_start[hit.edge]++] = {hit.w, hit.ray, static_cast<std::int32_t>(h)};
  }
  for (int f = edges; f > 0; --f) pair.face_start[f] = pair.face_start[f - 1];
  pair.face_start[0] = 0;
}

}  // namespace floatstage::recon
