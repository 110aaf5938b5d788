#include "recon/silhouette_grid.h"

#include <algorithm>
#include <cmath>

#include "recon/silhouette.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double point_segment_squared(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d chord = b - a, v = p - a;
  const double length2 = chord.squaredNorm();
  const double along = length2 > 0 ? std::clamp(v.dot(chord) / length2, 0.0, 1.0) : 0;
  return (v - along * chord).squaredNorm();
}

bool touch(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d, double gap) {
  if (std::max(a.x(), b.x()) + gap < std::min(c.x(), d.x()) ||
      std::max(c.x(), d.x()) + gap < std::min(a.x(), b.x()) ||
      std::max(a.y(), b.y()) + gap < std::min(c.y(), d.y()) ||
      std::max(c.y(), d.y()) + gap < std::min(a.y(), b.y())) {
    return false;
  }
  const double c_side = cross(b - a, c - a), d_side = cross(b - a, d - a);
  const double a_side = cross(d - c, a - c), b_side = cross(d - c, b - c);
  if ((c_side <= 0) != (d_side < 0) && (a_side <= 0) != (b_side < 0)) return true;
  if (gap <= 0) return false;
  const double least = std::min({point_segment_squared(a, c, d), point_segment_squared(b, c, d),
                                 point_segment_squared(c, a, b), point_segment_squared(d, a, b)});
  return least < gap * gap;
}

}  // namespace

std::pair<int, int> EdgeGrid::cell_of(const Vector2d& point) const {
  const Vector2d at = (point - origin_) / cell_;
  return {std::clamp(static_cast<int>(at.x()), 0, columns_ - 1),
          std::clamp(static_cast<int>(at.y()), 0, rows_ - 1)};
}

template <class Visit>
void EdgeGrid::each_cell(int edge, const Visit& visit) const {
  const Vector2d &p = points_[edge], &q = points_[next_[edge]];
  const auto [x0, y0] = cell_of(p.cwiseMin(q));
  const auto [x1, y1] = cell_of(p.cwiseMax(q));
  const Vector2d direction = q - p;
  const double reach = 0.5 * cell_ * (std::abs(direction.x()) + std::abs(direction.y())) * (1 + 1e-9);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      // A cell that the line of the edge misses is skipped: long edges must not fill their whole box.
      if (x1 > x0 && y1 > y0) {
        const Vector2d middle = origin_ + cell_ * Vector2d(x + 0.5, y + 0.5);
        if (std::abs(cross(direction, middle - p)) > reach) continue;
      }
      visit(static_cast<std::size_t>(y) * columns_ + x);
    }
  }
}

void EdgeGrid::fill(const Silhouette& outline) {
  points_ = outline.points.data();
  next_.resize(outline.points.size());
  Eigen::AlignedBox2d box;
  double length = 0;
  for (int k = 0; k < outline.polygons(); ++k) {
    for (int i = outline.starts[k]; i < outline.starts[k + 1]; ++i) {
      next_[i] = i + 1 < outline.starts[k + 1] ? i + 1 : outline.starts[k];
      box.extend(outline.points[i]);
      length += (outline.points[next_[i]] - outline.points[i]).norm();
    }
  }
  if (outline.points.empty()) box.extend(Vector2d::Zero().eval());
  const Vector2d size = box.sizes();
  // Cells about as large as an edge is long, and no more cells than a few per edge.
  const double count = std::max<double>(1, outline.points.size());
  cell_ = std::max({length / count, std::sqrt(size.x() * size.y() / (4 * count)), 1e-6});
  cell_ = std::max(cell_, std::max(size.x(), size.y()) / 4096);
  origin_ = box.min();
  columns_ = static_cast<int>(size.x() / cell_) + 1;
  rows_ = static_cast<int>(size.y() / cell_) + 1;
  start_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
  const int edges = static_cast<int>(outline.points.size());
  for (int e = 0; e < edges; ++e) each_cell(e, [&](std::size_t cell) { ++start_[cell + 1]; });
  for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
  edges_.resize(start_.back());
  fill_.assign(start_.begin(), start_.end() - 1);
  for (int e = 0; e < edges; ++e) each_cell(e, [&](std::size_t cell) { edges_[fill_[cell]++] = e; });
}

void EdgeGrid::touching_edges(double gap, std::vector<int>& out) const {
  out.clear();
  for (std::size_t cell = 0; cell + 1 < start_.size(); ++cell) {
    for (int i = start_[cell]; i < start_[cell + 1]; ++i) {
      for (int k = i + 1; k < start_[cell + 1]; ++k) {
        const int e = edges_[i], f = edges_[k];
        if (next_[e] == f || next_[f] == e) continue;
        if (touch(points_[e], points_[next_[e]], points_[f], points_[next_[f]], gap)) {
          out.push_back(e);
          out.push_back(f);
        }
      }
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
}

}  // namespace floatstage::recon
