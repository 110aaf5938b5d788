// Method:  chords instead of chains of points, as few as a tolerance allows
// Paper:   D. H. Douglas, T. K. Peucker, "Algorithms for the reduction of the number of points", 1973
// Differs: the topology stays: chords that come too near another
//          or jump over a point are cut again
// ADR:     0073, 0076

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "recon/silhouette.h"
#include "recon/silhouette_grid.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;

/// Which points of an outline are kept, and which chords have to be cut again.
class Simplifier {
 public:
  Simplifier(const Silhouette& outline, double tolerance, double longest, SilhouetteScratch& scratch)
      : outline_(outline),
        tolerance2_(tolerance * tolerance),
        longest2_(longest * longest),
        scratch_(scratch),
        keep_(scratch.keep),
        origin_(scratch.origin),
        stack_(scratch.stack) {
    keep_.assign(outline.points.size(), 0);
    stack_.clear();
  }

  void run(Silhouette& out) {
    for (int k = 0; k < outline_.polygons(); ++k) anchor(outline_.starts[k], outline_.starts[k + 1]);
    // Every round cuts the chords that are in conflict; with every point kept there is none, so this ends.
    Silhouette& result = scratch_.kept;
    for (bool cut = true; cut;) {
      find_kept(result);
      find_conflicts(result);
      cut = false;
      for (const int chord : scratch_.conflicts) cut |= cut_chord(origin_[chord], chord_end(result, chord));
    }
    fit_outline(outline_, result, std::span<const int>(origin_).first(result.points.size()),
                std::sqrt(tolerance2_), scratch_, out);
  }

 private:
  /// Two points of the polygon that Douglas-Peucker can start from: its first, and the one farthest from
  /// that.
  void anchor(int begin, int end) {
    int far = begin;
    double best = -1;
    for (int i = begin; i < end; ++i) {
      const double d = (outline_.points[i] - outline_.points[begin]).squaredNorm();
      if (d > best) {
        best = d;
        far = i;
      }
    }
    keep_[begin] = keep_[far] = 1;
    stack_.push_back({begin, far});
    stack_.push_back({far, end});  // `end` stands for `begin`, one lap later
    subdivide(begin, end);
    // A polygon needs three corners: the point farthest from the chord between the two.
    if (std::accumulate(keep_.begin() + begin, keep_.begin() + end, 0) < 3) {
      auto [first, first_distance] = farthest(begin, far, begin, end);
      auto [second, second_distance] = farthest(far, end, begin, end);
      keep_[first_distance > second_distance ? first : second] = 1;
    }
  }

  const Vector2d& point(int i, int begin, int end) const { return outline_.points[i == end ? begin : i]; }

  std::pair<int, double> farthest(int from, int to, int begin, int end) const {
    const Vector2d p = point(from, begin, end), chord = point(to, begin, end) - p;
    const double length2 = chord.squaredNorm();
    int best = from + 1;
    double best_distance = -1;
    for (int i = from + 1; i < to; ++i) {
      const Vector2d v = outline_.points[i] - p;
      const double along = length2 > 0 ? std::clamp(v.dot(chord) / length2, 0.0, 1.0) : 0;
      const double d = (v - along * chord).squaredNorm();
      if (d > best_distance) {
        best_distance = d;
        best = i;
      }
    }
    return {best, best_distance};
  }

  void subdivide(int begin, int end) {
    while (!stack_.empty()) {
      const auto [from, to] = stack_.back();
      stack_.pop_back();
      if (to - from < 2) continue;
      auto [split, distance] = farthest(from, to, begin, end);
      if (distance <= tolerance2_) {
        const double length2 = (point(to, begin, end) - point(from, begin, end)).squaredNorm();
        if (longest2_ <= 0 || length2 <= longest2_) continue;
        split = (from + to) / 2;
      }
      keep_[split] = 1;
      stack_.push_back({from, split});
      stack_.push_back({split, to});
    }
  }

  void find_kept(Silhouette& out) {
    out.clear();
    out.beyond_counts = outline_.beyond_counts;
    origin_.clear();
    for (int k = 0; k < outline_.polygons(); ++k) {
      out.starts.push_back(static_cast<int>(out.points.size()));
      for (int i = outline_.starts[k]; i < outline_.starts[k + 1]; ++i) {
        if (!keep_[i]) continue;
        out.points.push_back(outline_.points[i]);
        origin_.push_back(i);
      }
    }
    out.starts.push_back(static_cast<int>(out.points.size()));
    origin_.push_back(static_cast<int>(outline_.points.size()));
  }

  /// The full-resolution index at which the chord that starts at kept point `chord` ends (one lap later for
  /// the last).
  int chord_end(const Silhouette& result, int chord) const {
    const auto next = std::upper_bound(result.starts.begin(), result.starts.end(), chord);
    const int polygon = static_cast<int>(next - result.starts.begin()) - 1;
    return chord + 1 < *next ? origin_[chord + 1] : outline_.starts[polygon + 1];
  }

  void find_conflicts(const Silhouette& result) {
    EdgeGrid& grid = scratch_.grid;
    grid.fill(result);
    std::vector<int>& conflicts = scratch_.conflicts;
    grid.touching_edges(kOutlineGap, conflicts);
    for (int chord = 0; chord < static_cast<int>(result.points.size()); ++chord) {
      const int from = origin_[chord], to = chord_end(result, chord);
      if (to - from > 1 && swallows_a_point(grid, result, chord, from, to)) conflicts.push_back(chord);
    }
  }

  /// Whether a kept point of some other chain lies between the chord and the chain that it replaces.
  bool swallows_a_point(const EdgeGrid& grid, const Silhouette& result, int chord, int from, int to) const {
    const auto next = std::upper_bound(outline_.starts.begin(), outline_.starts.end(), from);
    const int begin = *(next - 1), end = *next;
    Eigen::AlignedBox2d box;
    for (int i = from; i <= to; ++i) box.extend(point(i, begin, end));
    const int after = grid.next(chord);
    return grid.any_point_in(box, [&](int candidate) {
      if (candidate == chord || candidate == after) return false;
      const Vector2d q = result.points[candidate];
      bool inside = false;
      for (int i = from; i <= to; ++i) {
        const Vector2d &u = point(i, begin, end), &v = point(i < to ? i + 1 : from, begin, end);
        if ((u.y() > q.y()) != (v.y() > q.y()) &&
            q.x() < u.x() + (q.y() - u.y()) / (v.y() - u.y()) * (v.x() - u.x())) {
          inside = !inside;
        }
      }
      return inside;
    });
  }

  bool cut_chord(int from, int to) {
    if (to - from < 2) return false;
    const auto next = std::upper_bound(outline_.starts.begin(), outline_.starts.end(), from);
    const int begin = *(next - 1), end = *next;
    keep_[farthest(from, to, begin, end).first] = 1;
    return true;
  }

  const Silhouette& outline_;
  double tolerance2_, longest2_;
  SilhouetteScratch& scratch_;
  std::vector<char>& keep_;
  std::vector<int>& origin_;
  std::vector<std::pair<int, int>>& stack_;
};

}  // namespace

void simplify_outline(const Silhouette& outline, double tolerance, double longest, SilhouetteScratch& scratch,
                      Silhouette& out) {
  if (outline.empty() || tolerance <= 0) {
    out = outline;
  } else {
    Simplifier(outline, tolerance, longest, scratch).run(out);
  }
}

Silhouette simplify_outline(const Silhouette& outline, double tolerance, double longest) {
  SilhouetteScratch scratch;
  Silhouette out;
  simplify_outline(outline, tolerance, longest, scratch, out);
  return out;
}

}  // namespace floatstage::recon
