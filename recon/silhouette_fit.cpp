// Method:  chords moved sideways until they cut off as much
//          of their outline as they add
// Paper:   none: the area between a chain and its chord, over the chord's length
// Differs: corners that would change the topology by moving go back
// ADR:     0073

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "recon/silhouette.h"
#include "recon/silhouette_grid.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// How far each chord has to move to its left (px) so that it cuts off as much of its chain as it adds.
void find_offsets(const Silhouette& full, const Silhouette& simple, std::span<const int> origin,
                  std::vector<double>& out) {
  out.assign(simple.points.size(), 0);
  for (int k = 0; k < simple.polygons(); ++k) {
    const int begin = full.starts[k], end = full.starts[k + 1];
    for (int e = simple.starts[k]; e < simple.starts[k + 1]; ++e) {
      const int from = origin[e], to = e + 1 < simple.starts[k + 1] ? origin[e + 1] : end;
      const Vector2d p = full.points[from];
      const Vector2d q = full.points[to == end ? begin : to];
      double twice = 0;
      for (int i = from; i + 1 < to; ++i) {
        twice += cross(full.points[i] - p, full.points[i + 1] - p);
      }
      if (to - from > 1) twice += cross(full.points[to - 1] - p, q - p);
      const double length = (q - p).norm();
      // The area between chain and chord, positive where the chain runs to the chord's left (on the screen: y
      // down).
      out[e] = length > 0 ? twice / (2 * length) : 0;
    }
  }
}

// Each corner where its two edges meet when both are moved outwards by their offset, at most `most` away.
void move_corners(const Silhouette& simple, double most, SilhouetteScratch& scratch) {
  const std::vector<double>& offset = scratch.offsets;
  const EdgeGrid& grid = scratch.grid;
  std::vector<Vector2d>& moved = scratch.moved;
  moved.resize(simple.points.size());
  std::vector<int>& previous = scratch.previous;
  previous.resize(simple.points.size());
  for (int e = 0; e < static_cast<int>(previous.size()); ++e) previous[grid.next(e)] = e;
  const auto outward = [&](int e) {
    const Vector2d d = (simple.points[grid.next(e)] - simple.points[e]).normalized();
    return Vector2d(d.y(), -d.x());
  };
  for (int e = 0; e < static_cast<int>(moved.size()); ++e) {
    const int in = previous[e];
    const Vector2d n = outward(in), m = outward(e);
    const double turn = cross(n, m);
    Vector2d move;
    if (std::abs(turn) > 0.2) {  // where the two moved lines meet
      move = Vector2d(offset[in] * m.y() - offset[e] * n.y(), offset[e] * n.x() - offset[in] * m.x()) / turn;
    } else {
      move = 0.25 * (offset[in] + offset[e]) * (n + m);
    }
    const double length = move.norm();
    if (!(length <= most)) move *= most / length;
    moved[e] = move.allFinite() ? Vector2d(simple.points[e] + move) : simple.points[e];
  }
}

// Whether moving edge e to where it is in `out` would sweep over a corner of another chain.
bool sweeps_over_a_corner(const EdgeGrid& grid, const Silhouette& simple, const Silhouette& out, int e,
                          int f) {
  const std::array<Vector2d, 4> swept = {simple.points[e], simple.points[f], out.points[f], out.points[e]};
  Eigen::AlignedBox2d box;
  for (const Vector2d& p : swept) box.extend(p);
  return grid.any_point_in(box, [&](int other) {
    if (other == e || other == f) return false;
    bool inside = false;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector2d &u = swept[k], &v = swept[(k + 1) % 4], &q = out.points[other];
      if ((u.y() > q.y()) != (v.y() > q.y()) &&
          q.x() < u.x() + (q.y() - u.y()) / (v.y() - u.y()) * (v.x() - u.x())) {
        inside = !inside;
      }
    }
    return inside;
  });
}

}  // namespace

void fit_outline(const Silhouette& full, const Silhouette& simple, std::span<const int> origin, double most,
                 SilhouetteScratch& scratch, Silhouette& out) {
  find_offsets(full, simple, origin, scratch.offsets);
  scratch.grid.fill(simple);
  move_corners(simple, most, scratch);
  const std::vector<Vector2d>& moved = scratch.moved;
  // Corners whose move would let two chains touch, or jump over a corner of another chain, go back.
  out = simple;
  std::vector<char>& back = scratch.back;
  back.assign(moved.size(), 0);
  for (bool again = true; again;) {
    for (std::size_t e = 0; e < moved.size(); ++e) out.points[e] = back[e] ? simple.points[e] : moved[e];
    EdgeGrid& grid = scratch.moved_grid;
    grid.fill(out);
    again = false;
    const auto retreat = [&](int e) {
      again |= !back[e];
      back[e] = 1;
    };
    grid.touching_edges(kOutlineGap, scratch.conflicts);
    for (const int e : scratch.conflicts) {
      retreat(e);
      retreat(grid.next(e));
    }
    for (int e = 0; e < static_cast<int>(moved.size()); ++e) {
      const int f = grid.next(e);
      if ((back[e] && back[f]) || !sweeps_over_a_corner(grid, simple, out, e, f)) continue;
      retreat(e);
      retreat(f);
    }
  }
}

}  // namespace floatstage::recon
