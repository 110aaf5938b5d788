#include "recon/outline.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "recon/silhouette.h"
#include "recon/silhouette_grid.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;

/// The longest chord whose image under the lens stays within `sag` px of a straight line; 0 when all do.
double longest_chord(double bend, double sag) {
  return bend > 1e-12 ? std::max(2.0, std::sqrt(8 * sag / bend)) : 0;
}

/// Replaces every point i by point_of(i), or leaves it out where that is absent. Polygons of fewer than three
/// points go.
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

/// Points that fell together, as rounding on the way here may do, become one, and so do spikes without width.
/// `given` is memory.
void drop_repeated(Silhouette& given, Silhouette& outline) {
  do {
    given = outline;
    int k = 0;
    const auto counts = [&](int i) -> std::optional<Vector2d> {
      while (i >= given.starts[k + 1]) ++k;
      const int begin = given.starts[k], end = given.starts[k + 1];
      const Vector2d &before = given.points[i > begin ? i - 1 : end - 1], &at = given.points[i],
                     &after = given.points[i + 1 < end ? i + 1 : begin];
      const Vector2d in = at - before, out = after - at;
      const bool turns_back =
          in.dot(out) < 0 && std::abs(in.x() * out.y() - in.y() * out.x()) <= 1e-9 * in.norm() * out.norm();
      return in.squaredNorm() <= 1e-12 || turns_back ? std::nullopt : std::optional(at);
    };
    rebuild(counts, outline);
  } while (outline.points.size() < given.points.size());
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

/// How often an outline's other polygons go around the first corner of polygon k.
int surrounding(const Silhouette& outline, std::span<const Eigen::AlignedBox2d> boxes, int k) {
  const Eigen::Vector2d corner = outline.points[outline.starts[k]];
  int turns = 0;
  for (int other = 0; other < outline.polygons(); ++other) {
    if (other == k || !boxes[other].contains(corner)) continue;
    const int begin = outline.starts[other], end = outline.starts[other + 1];
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector2d &a = outline.points[i], &b = outline.points[i + 1 < end ? i + 1 : begin];
      if ((a.y() <= corner.y()) == (b.y() <= corner.y())) continue;
      if (a.x() + (corner.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) < corner.x())
        turns += b.y() < a.y() ? 1 : -1;
    }
  }
  return turns;
}

/// Adds the background that was seen around an outline that is not cut: what lies outside the picture is then
/// unknown.
void make_beyond_unknown(const CameraModel& model, double bend, Silhouette& outline) {
  if (outline.empty() || outline.beyond_counts) return;
  constexpr double kGap = 0.1;   // px, where a coarse outline leaves the picture
  constexpr double kSag = 0.05;  // px, of the border as the lens bends it
  Eigen::AlignedBox2d border(Vector2d(0, 0), Vector2d(model.width, model.height));
  for (const Vector2d& p : outline.points)
    border.extend(p + Vector2d(kGap, kGap)).extend(p - Vector2d(kGap, kGap));
  const Vector2d &lo = border.min(), &hi = border.max();
  const Vector2d corners[] = {lo, {lo.x(), hi.y()}, hi, {hi.x(), lo.y()}};
  const double longest = longest_chord(bend, kSag);
  for (int side = 0; side < 4; ++side) {
    const Vector2d &from = corners[side], &to = corners[(side + 1) % 4];
    const int pieces = longest > 0 ? static_cast<int>(std::ceil((to - from).norm() / longest)) : 1;
    for (int k = 0; k < pieces; ++k)
      outline.points.emplace_back(from + (to - from) * (static_cast<double>(k) / pieces));
  }
  outline.starts.push_back(static_cast<int>(outline.points.size()));
  outline.beyond_counts = true;
}

/// Simplifies scratch.traced until options.most_points are enough and no two chains cross, neither with the
/// lens nor without. `bent` is what comes out before the lens is removed.
OutlineDetail simplify_for_lens(const CameraModel& model, double bend, const SilhouetteOptions& options,
                                bool foreign, SilhouetteScratch& scratch, Silhouette& bent,
                                Silhouette& straight) {
  constexpr double kCoarsest = 4;  // px: beyond, only more specks are left out
  constexpr std::size_t kTraced = 4;
  OutlineDetail detail{options.tolerance, options.smallest, false};
  Silhouette& full = scratch.traced;
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
    simplify_outline(full, tolerance, longest_chord(bend, 0.1 * tolerance), scratch, bent);
    while (bent.points.size() > most) {
      drop_more();
      tolerance = detail.tolerance =
          std::max(detail.tolerance, std::min(kCoarsest, std::max(0.25, 2 * detail.tolerance)));
      simplify_outline(full, tolerance, longest_chord(bend, 0.1 * tolerance), scratch, bent);
      round = 0;
    }
    straight = bent;
    if (!lens && !foreign) return detail;  // what is traced here is simple
    if (lens) remove_lens(model, straight);
    if (is_simple(straight, scratch)) return detail;
    if (round == 4 || tolerance <= 0) {
      drop_conflicts(scratch, straight);
      detail.torn = !tells_sides(straight, scratch.polygons);
      return detail;
    }
  }
}

}  // namespace

struct OutlineWorkspace::Impl {
  CameraModel model;
  double bend = 0;
  SilhouetteScratch scratch;
};

OutlineWorkspace::OutlineWorkspace() : impl_(std::make_unique<Impl>()) {}
OutlineWorkspace::OutlineWorkspace(OutlineWorkspace&&) noexcept = default;
OutlineWorkspace& OutlineWorkspace::operator=(OutlineWorkspace&&) noexcept = default;
OutlineWorkspace::~OutlineWorkspace() = default;

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

bool is_simple(const Silhouette& outline) {
  SilhouetteScratch scratch;
  return is_simple(outline, scratch);
}

bool tells_sides(const Silhouette& outline, PolygonBounds& memory) {
  auto& [boxes, areas] = memory;
  boxes.assign(static_cast<std::size_t>(outline.polygons()), {});
  areas.assign(boxes.size(), 0);
  for (int k = 0; k < outline.polygons(); ++k) {
    const int begin = outline.starts[k], end = outline.starts[k + 1];
    for (int i = begin; i < end; ++i) {
      const Vector2d &p = outline.points[i], &q = outline.points[i + 1 < end ? i + 1 : begin];
      boxes[k].extend(p);
      areas[k] += p.x() * q.y() - p.y() * q.x();
    }
  }
  for (int k = 0; k < outline.polygons(); ++k) {
    const int around = surrounding(outline, boxes, k) + (outline.beyond_counts ? 1 : 0);
    if (around != (areas[k] > 0 ? 0 : 1)) return false;
  }
  return true;
}

OutlineDetail undistorted_outline(const Matte& matte, const CameraModel& model, double bend,
                                  const SilhouetteOptions& options, SilhouetteScratch& scratch,
                                  Silhouette& out) {
  trace_outline(matte, options.unknown_beyond, scratch, scratch.traced);
  return simplify_for_lens(model, bend, options, false, scratch, scratch.bent, out);
}

OutlineDetail undistorted_outline(const Silhouette& outline, const CameraModel& model, double bend,
                                  const SilhouetteOptions& options, SilhouetteScratch& scratch,
                                  Silhouette& out) {
  scratch.traced = outline;
  if (!outline.empty()) drop_repeated(scratch.given, scratch.traced);
  if (options.unknown_beyond) make_beyond_unknown(model, bend, scratch.traced);
  return simplify_for_lens(model, bend, options, true, scratch, scratch.bent, out);
}

OutlineDetail outline_of(const Matte& matte, const CameraModel& model, const SilhouetteOptions& options,
                         OutlineWorkspace& workspace, Silhouette& out) {
  OutlineWorkspace::Impl& own = workspace.impl();
  if (!(own.model == model)) {
    own.model = model;
    own.bend = lens_bend(model);
  }
  SilhouetteScratch& scratch = own.scratch;
  trace_outline(matte, options.unknown_beyond, scratch, scratch.traced);
  return simplify_for_lens(model, own.bend, options, false, scratch, out, scratch.bent);
}

Silhouette outline_of(const Matte& matte, const CameraModel& model, const SilhouetteOptions& options) {
  OutlineWorkspace workspace;
  Silhouette out;
  outline_of(matte, model, options, workspace, out);
  return out;
}

}  // namespace floatstage::recon
