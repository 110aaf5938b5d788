#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "recon/silhouette.h"
#include "recon/silhouette_grid.h"

namespace floatstage {
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
    fit_outline(outline_, result, std::span<const int>(origin_).first(result.points.size()), std::sqrt(tolerance2_),
                scratch_, out);
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

/// The longest chord whose image under the lens stays within `sag` px of a straight line; 0 when all do.
double longest_chord(double bend, double sag) {
  return bend > 1e-12 ? std::max(2.0, std::sqrt(8 * sag / bend)) : 0;
}

/// Replaces every point i by point_of(i), or leaves it out where that is absent. Polygons of fewer than three points
/// go.
template <class PointOf>
void rebuild(const PointOf& point_of, Silhouette& outline) {
  std::size_t kept = 0, polygons = 0;
  for (int k = 0; k < outline.polygons(); ++k) {
    const std::size_t first = kept;
    const int begin = outline.starts[k], end = outline.starts[k + 1];
    for (int i = begin; i < end; ++i) {
      if (const std::optional<Eigen::Vector2d> point = point_of(i)) outline.points[kept++] = *point;
    }
    if (kept - first < 3) {
      kept = first;
    } else {
      outline.starts[polygons++] = static_cast<int>(first);
    }
  }
  outline.points.resize(kept);
  outline.starts.resize(polygons + 1);
  outline.starts[polygons] = static_cast<int>(kept);
}

void remove_lens(const CameraModel& model, Silhouette& outline) {
  const CameraModel ideal = pinhole(model);
  const auto straight = [&](int i) -> std::optional<Eigen::Vector2d> {
    const auto ray = unproject(model, outline.points[i]);
    const auto pixel = ray ? project(ideal, *ray) : std::nullopt;
    return pixel && pixel->allFinite() ? pixel : std::nullopt;
  };
  rebuild(straight, outline);
}

bool is_simple(const Silhouette& outline, SilhouetteScratch& scratch) {
  if (outline.empty()) return true;
  scratch.grid.fill(outline);
  scratch.grid.touching_edges(0, scratch.conflicts);
  return scratch.conflicts.empty();
}

/// Last resort where a lens cannot be undone over a part of the picture: the points whose edges cross are
/// left out until none do. Ends, because every round leaves some out.
void drop_conflicts(SilhouetteScratch& scratch, Silhouette& outline) {
  while (!is_simple(outline, scratch)) {
    scratch.back.assign(outline.points.size(), 0);
    for (const int e : scratch.conflicts) scratch.back[e] = scratch.back[scratch.grid.next(e)] = 1;
    const auto kept = [&](int i) {
      return scratch.back[i] ? std::nullopt : std::optional<Eigen::Vector2d>(outline.points[i]);
    };
    rebuild(kept, outline);
  }
}

}  // namespace

double lens_bend(const CameraModel& model) {
  if (std::holds_alternative<std::monostate>(model.lens)) return 0;
  constexpr int kCells = 8;
  const double h = std::max(model.width, model.height) / 32.0;
  const CameraModel ideal = pinhole(model);
  double bend = 0;  // px per px²
  const auto straight = [&](const Vector2d& p) -> std::optional<Vector2d> {
    const auto ray = unproject(model, p);
    return ray ? project(ideal, *ray) : std::nullopt;
  };
  for (int y = 0; y <= kCells; ++y) {
    for (int x = 0; x <= kCells; ++x) {
      const Vector2d p(model.width * x / double(kCells), model.height * y / double(kCells));
      for (const Vector2d& step : {Vector2d(h, 0), Vector2d(0, h), Vector2d(h, h)}) {
        const auto a = straight(p - step), b = straight(p), c = straight(p + step);
        if (a && b && c) bend = std::max(bend, (*a - 2 * *b + *c).norm() / step.squaredNorm());
      }
    }
  }
  return bend;
}

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

bool is_simple(const Silhouette& outline) {
  SilhouetteScratch scratch;
  return is_simple(outline, scratch);
}

OutlineDetail undistorted_outline(const Matte& matte, const CameraModel& model, double bend,
                                  const SilhouetteOptions& options, SilhouetteScratch& scratch, Silhouette& out) {
  constexpr double kCoarsest = 4;  // px: beyond, only more specks are left out
  constexpr std::size_t kTraced = 4;
  OutlineDetail detail{options.tolerance, options.smallest, false};
  Silhouette& full = scratch.traced;
  trace_outline(matte, options.unknown_beyond, scratch, full);
  const auto drop_more = [&] {
    detail.coarser = true;
    detail.smallest = std::max(16.0, 4 * detail.smallest);
    drop_specks(detail.smallest, full);
  };
  const std::size_t most = static_cast<std::size_t>(options.most_points);
  if (options.smallest > 0) drop_specks(options.smallest, full);
  while (full.points.size() > kTraced * most) drop_more();
  const bool lens = !std::holds_alternative<std::monostate>(model.lens);
  double tolerance = detail.tolerance;
  // The lens may fold neighbouring chains over each other where it bends strongly: then keep more points.
  for (int round = 0;; ++round, tolerance /= 4) {
    simplify_outline(full, tolerance, longest_chord(bend, 0.1 * tolerance), scratch, out);
    while (out.points.size() > most) {
      drop_more();
      tolerance = detail.tolerance = std::max(detail.tolerance, std::min(kCoarsest, std::max(0.25, 2 * detail.tolerance)));
      simplify_outline(full, tolerance, longest_chord(bend, 0.1 * tolerance), scratch, out);
      round = 0;
    }
    if (!lens) return detail;
    remove_lens(model, out);
    if (is_simple(out, scratch)) return detail;
    if (round == 4) {
      drop_conflicts(scratch, out);
      return detail;
    }
  }
}

}  // namespace floatstage
