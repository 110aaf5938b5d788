#include "recon/exact_polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace floatstage {
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

bool PolygonCutter::is_ear(std::size_t before, std::size_t at, std::size_t after) const {
  const std::int32_t ia = loop_[before], ib = loop_[at], ic = loop_[after];
  const Vector2d &a = points_[ia], &b = points_[ib], &c = points_[ic];
  if (ia == ic || !(clockwise(a, b, c) > 0)) return false;
  for (const std::int32_t other : loop_) {
    if (other == ia || other == ib || other == ic) continue;
    if (points_[other] == a || points_[other] == b || points_[other] == c) continue;
    if (in_triangle(points_[other], a, b, c)) return false;
  }
  return true;
}

void PolygonCutter::clip(std::vector<std::int32_t>& triangles) {
  const auto emit = [&](std::size_t a, std::size_t b, std::size_t c) {
    triangles.insert(triangles.end(), {loop_[a], loop_[b], loop_[c]});
  };
  while (loop_.size() > 3) {
    const std::size_t n = loop_.size();
    std::size_t best = 0;
    double best_score = -std::numeric_limits<double>::infinity();
    bool found = false;
    for (std::size_t at = 0; at < n; ++at) {
      const std::size_t before = at == 0 ? n - 1 : at - 1, after = at + 1 == n ? 0 : at + 1;
      if (n == 4) {
        // The diagonal for which the worse of the two triangles is better.
        const std::size_t opposite = (at + 2) % 4;
        const double score =
            std::min(clockwise(points_[loop_[before]], points_[loop_[at]], points_[loop_[after]]),
                     clockwise(points_[loop_[after]], points_[loop_[opposite]], points_[loop_[before]]));
        if (score > best_score) {
          best_score = score;
          best = at;
        }
        continue;
      }
      if (is_ear(before, at, after)) {
        best = at;
        found = true;
        break;
      }
      if (loop_[before] == loop_[after]) continue;  // both sides of a bridge
      const double area = clockwise(points_[loop_[before]], points_[loop_[at]], points_[loop_[after]]);
      // No ear at all happens only to polygons flattened by rounding: then the least bad corner goes.
      if (!found && area > best_score &&
          (area < 0 || best_score == -std::numeric_limits<double>::infinity())) {
        best_score = area;
        best = at;
      }
    }
    const std::size_t before = best == 0 ? n - 1 : best - 1, after = best + 1 == n ? 0 : best + 1;
    emit(before, best, after);
    loop_.erase(loop_.begin() + static_cast<std::ptrdiff_t>(best));
  }
  if (loop_.size() == 3) emit(0, 1, 2);
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

void PolygonCutter::cut(std::span<const Vector2d> points, std::span<const std::int32_t> ends,
                        std::vector<std::int32_t>& triangles) {
  points_ = points;
  const auto load = [&](std::int32_t begin, std::int32_t end) {
    loop_.resize(static_cast<std::size_t>(end - begin));
    for (std::int32_t k = begin; k < end; ++k) loop_[k - begin] = k;
  };
  if (ends.size() == 1) {
    load(0, ends[0]);
    clip(triangles);
    return;
  }
  rings_.clear();
  std::int32_t begin = 0;
  int holes = 0;
  for (const std::int32_t end : ends) {
    double area = 0;
    for (std::int32_t k = begin; k < end; ++k) {
      area += clockwise(points[begin], points[k], points[k + 1 < end ? k + 1 : begin]);
    }
    rings_.push_back({begin, end, area});
    holes += area < 0;
    begin = end;
  }
  if (holes == static_cast<int>(rings_.size())) holes = 0;  // flattened by rounding: treat all as outlines
  const auto is_hole = [&](const Ring& ring) { return holes > 0 && ring.area < 0; };
  const auto contains = [&](const Ring& ring, const Vector2d& p) {
    bool inside = false;
    for (std::int32_t k = ring.begin; k < ring.end; ++k) {
      const Vector2d &u = points[k], &v = points[k + 1 < ring.end ? k + 1 : ring.begin];
      if ((u.y() > p.y()) != (v.y() > p.y()) &&
          p.x() < u.x() + (p.y() - u.y()) / (v.y() - u.y()) * (v.x() - u.x())) {
        inside = !inside;
      }
    }
    return inside;
  };
  const auto left_of = [&](const Ring& ring) {
    double left = points[ring.begin].x();
    for (std::int32_t k = ring.begin; k < ring.end; ++k) left = std::min(left, points[k].x());
    return left;
  };
  // Each hole belongs to the smallest outline around it.
  std::vector<std::vector<const Ring*>> holes_of(rings_.size());
  for (const Ring& hole : rings_) {
    if (!is_hole(hole)) continue;
    std::size_t owner = rings_.size();
    for (std::size_t r = 0; r < rings_.size(); ++r) {
      if (is_hole(rings_[r]) || (owner < rings_.size() && rings_[r].area >= rings_[owner].area)) continue;
      if (contains(rings_[r], points[hole.begin])) owner = r;
    }
    if (owner == rings_.size()) {
      owner = 0;
      while (is_hole(rings_[owner])) ++owner;
    }
    holes_of[owner].push_back(&hole);
  }
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    if (is_hole(rings_[r])) continue;
    load(rings_[r].begin, rings_[r].end);
    // From left to right: then what lies to the left of a hole is connected already.
    std::sort(holes_of[r].begin(), holes_of[r].end(),
              [&](const Ring* a, const Ring* b) { return left_of(*a) < left_of(*b); });
    for (const Ring* hole : holes_of[r]) bridge(*hole);
    clip(triangles);
  }
}

}  // namespace floatstage
