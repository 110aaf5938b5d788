// Method:  ear clipping; a hole is joined to the outline around it by a bridge first
// Paper:   G. H. Meisters, "Polygons have ears", American Mathematical Monthly 82, 1975
// Differs: n + 2 holes - 2 triangles always, the least bad ear where rounding leaves none: a closed surface
//          stays closed
// ADR:     0070

#include "recon/exact/exact_polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;

/// Twice the area of the triangle, positive when clockwise.
double clockwise(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.y() - a.y()) * (c.x() - a.x()) - (b.x() - a.x()) * (c.y() - a.y());
}

bool in_triangle(const Vector2d& p, const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return clockwise(a, b, p) >= 0 && clockwise(b, c, p) >= 0 && clockwise(c, a, p) >= 0;
}

}  // namespace

bool PolygonCutter::is_ear(std::int32_t at) const {
  const std::int32_t ia = loop_[prev_[at]], ib = loop_[at], ic = loop_[next_[at]];
  const Vector2d &a = points_[ia], &b = points_[ib], &c = points_[ic];
  if (ia == ic || !(clockwise(a, b, c) > 0)) return false;
  const Vector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  for (const std::int32_t node : reflex_) {
    const std::int32_t other = loop_[node];
    const Vector2d& p = points_[other];
    if (p.x() < low.x() || p.x() > high.x() || p.y() < low.y() || p.y() > high.y()) continue;
    if (next_[node] < 0 || other == ia || other == ib || other == ic) continue;
    if (p == a || p == b || p == c) continue;
    if (in_triangle(p, a, b, c)) return false;
  }
  return true;
}

/// No ear at all happens only to polygons flattened by rounding: then the least bad corner goes.
std::int32_t PolygonCutter::least_bad(std::int32_t from, std::int32_t remaining) const {
  std::int32_t best = from;
  double best_area = -std::numeric_limits<double>::infinity();
  for (std::int32_t at = from; remaining > 0; at = next_[at], --remaining) {
    if (loop_[prev_[at]] == loop_[next_[at]]) continue;  // both sides of a bridge
    const double area = clockwise(points_[loop_[prev_[at]]], points_[loop_[at]], points_[loop_[next_[at]]]);
    if (area > best_area && (area < 0 || best_area == -std::numeric_limits<double>::infinity())) {
      best_area = area;
      best = at;
    }
  }
  return best;
}

void PolygonCutter::clip(std::vector<std::int32_t>& triangles) {
  std::int32_t remaining = static_cast<std::int32_t>(loop_.size());
  if (remaining < 3) return;
  next_.resize(loop_.size());
  prev_.resize(loop_.size());
  for (std::int32_t k = 0; k < remaining; ++k) {
    next_[k] = k + 1 < remaining ? k + 1 : 0;
    prev_[k] = k > 0 ? k - 1 : remaining - 1;
  }
  const auto corner = [&](std::int32_t node) -> const Vector2d& { return points_[loop_[node]]; };
  reflex_.clear();  // only these can lie in an ear
  for (std::int32_t k = 0; k < remaining && remaining > 4; ++k) {
    if (!(clockwise(corner(prev_[k]), corner(k), corner(next_[k])) > 0)) reflex_.push_back(k);
  }
  std::int32_t at = 0;
  const auto cut = [&](std::int32_t node) {
    triangles.insert(triangles.end(), {loop_[prev_[node]], loop_[node], loop_[next_[node]]});
    at = next_[node];
    next_[prev_[node]] = next_[node];
    prev_[next_[node]] = prev_[node];
    next_[node] = -1;
    --remaining;
  };
  for (std::int32_t failed = 0; remaining > 4;) {
    if (is_ear(at)) {
      cut(at);
      failed = 0;
    } else if (++failed < remaining) {
      at = next_[at];
    } else {
      cut(least_bad(at, remaining));
      failed = 0;
    }
  }
  if (remaining == 4) {
    // The diagonal for which the worse of the two triangles is better.
    std::int32_t best = at;
    double best_score = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < 4; ++k, at = next_[at]) {
      const std::int32_t before = prev_[at], after = next_[at];
      const double score = std::min(clockwise(corner(before), corner(at), corner(after)),
                                    clockwise(corner(after), corner(next_[after]), corner(before)));
      if (score > best_score) {
        best_score = score;
        best = at;
      }
    }
    cut(best);
  }
  triangles.insert(triangles.end(), {loop_[prev_[at]], loop_[at], loop_[next_[at]]});
}

void PolygonCutter::bridge(const Ring& hole) {
  // From the hole's leftmost point to the outline: the nearest point that sees it.
  std::int32_t left = hole.begin;
  for (std::int32_t k = hole.begin; k < hole.end; ++k) {
    if (points_[k].x() < points_[left].x()) left = k;
  }
  const Vector2d p = points_[left];
  std::size_t best = 0;
  double best_distance = std::numeric_limits<double>::infinity();
  const auto blocked = [&](const Vector2d& q) {
    const auto crosses = [&](const Vector2d& u, const Vector2d& v) {
      if (u == q || v == q || u == p || v == p) return false;
      return (clockwise(p, q, u) > 0) != (clockwise(p, q, v) > 0) &&
             (clockwise(u, v, p) > 0) != (clockwise(u, v, q) > 0);
    };
    for (const Ring& ring : rings_) {
      for (std::int32_t k = ring.begin; k < ring.end; ++k) {
        if (crosses(points_[k], points_[k + 1 < ring.end ? k + 1 : ring.begin])) return true;
      }
    }
    for (std::size_t k = 0; k < loop_.size(); ++k) {  // earlier bridges
      if (crosses(points_[loop_[k]], points_[loop_[(k + 1) % loop_.size()]])) return true;
    }
    return false;
  };
  for (int pass = 0; pass < 2 && !std::isfinite(best_distance); ++pass) {
    for (std::size_t k = 0; k < loop_.size(); ++k) {
      const Vector2d q = points_[loop_[k]];
      const double distance = (q - p).squaredNorm();
      if (distance >= best_distance || (pass == 0 && blocked(q))) continue;
      // Where the outline passes a point twice (an earlier bridge), the bridge must start within the corner's
      // angle.
      const Vector2d before = points_[loop_[k == 0 ? loop_.size() - 1 : k - 1]];
      const Vector2d after = points_[loop_[k + 1 == loop_.size() ? 0 : k + 1]];
      const bool convex = clockwise(before, q, after) > 0;
      const bool right_of_in = clockwise(before, q, p) > 0, right_of_out = clockwise(q, after, p) > 0;
      if (pass == 0 && !(convex ? right_of_in && right_of_out : right_of_in || right_of_out)) continue;
      best = k;
      best_distance = distance;
    }
  }
  merged_.assign(loop_.begin(), loop_.begin() + static_cast<std::ptrdiff_t>(best) + 1);
  for (std::int32_t k = left; k < hole.end; ++k) merged_.push_back(k);
  for (std::int32_t k = hole.begin; k <= left; ++k) merged_.push_back(k);
  merged_.insert(merged_.end(), loop_.begin() + static_cast<std::ptrdiff_t>(best), loop_.end());
  loop_.swap(merged_);
}

void PolygonCutter::load(const Ring& ring) {
  loop_.resize(static_cast<std::size_t>(ring.end - ring.begin));
  for (std::int32_t k = ring.begin; k < ring.end; ++k) loop_[k - ring.begin] = k;
}

void PolygonCutter::find_rings(std::span<const std::int32_t> ends) {
  rings_.clear();
  std::int32_t begin = 0;
  std::size_t holes = 0;
  for (const std::int32_t end : ends) {
    double area = 0;
    for (std::int32_t k = begin; k < end; ++k)
      area += clockwise(points_[begin], points_[k], points_[k + 1 < end ? k + 1 : begin]);
    rings_.push_back({begin, end, area, area < 0});
    holes += area < 0;
    begin = end;
  }
  if (holes < rings_.size()) return;
  for (Ring& ring : rings_) ring.is_hole = false;  // flattened by rounding: treat all as outlines
}

bool PolygonCutter::contains(const Ring& ring, const Vector2d& p) const {
  bool inside = false;
  for (std::int32_t k = ring.begin; k < ring.end; ++k) {
    const Vector2d &u = points_[k], &v = points_[k + 1 < ring.end ? k + 1 : ring.begin];
    if ((u.y() > p.y()) != (v.y() > p.y()) &&
        p.x() < u.x() + (p.y() - u.y()) / (v.y() - u.y()) * (v.x() - u.x())) {
      inside = !inside;
    }
  }
  return inside;
}

std::size_t PolygonCutter::owner_of(const Ring& hole) const {
  std::size_t owner = rings_.size();
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    if (rings_[r].is_hole || (owner < rings_.size() && rings_[r].area >= rings_[owner].area)) continue;
    if (contains(rings_[r], points_[hole.begin])) owner = r;
  }
  if (owner < rings_.size()) return owner;
  owner = 0;
  while (rings_[owner].is_hole) ++owner;
  return owner;
}

void PolygonCutter::sort_holes() {
  holes_.clear();
  for (std::size_t h = 0; h < rings_.size(); ++h) {
    if (!rings_[h].is_hole) continue;
    double left = points_[rings_[h].begin].x();
    for (std::int32_t k = rings_[h].begin; k < rings_[h].end; ++k) left = std::min(left, points_[k].x());
    holes_.push_back({owner_of(rings_[h]), left, h});
  }
  std::sort(holes_.begin(), holes_.end());
}

void PolygonCutter::cut(std::span<const Vector2d> points, std::span<const std::int32_t> ends,
                        std::vector<std::int32_t>& triangles) {
  points_ = points;
  if (ends.size() == 1) {
    load({0, ends[0], 0, false});
    clip(triangles);
    return;
  }
  find_rings(ends);
  sort_holes();
  auto hole = holes_.begin();
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    if (rings_[r].is_hole) continue;
    load(rings_[r]);
    for (; hole != holes_.end() && hole->owner == r; ++hole) bridge(rings_[hole->ring]);
    clip(triangles);
  }
}

}  // namespace floatstage::recon
