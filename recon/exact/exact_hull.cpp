// Method:  the hull of polygonal silhouettes: one planar sweep a contour edge, then a weld by names
// Paper:   J.-S. Franco, E. Boyer, "Exact polyhedral visual hulls", 2003; thesis, sections 2.8.2 and 11.5
// Differs: no tolerance: each face is found by itself; an open result is computed again, at last in
//          integers
// ADR:     0070, 0071, 0074, 0076

#include "recon/exact/exact_hull.h"

#include <algorithm>
#include <chrono>

#include "core/check.h"
#include "core/parallel.h"

namespace floatstage::recon {
namespace {

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// A frame of more is noise: a person seen from 60 sides needs a hundredth. Shared out to the parts.
constexpr std::int64_t kMostRelations = 1'000'000'000;
constexpr int kFacesPerPart =
    FaceSweep::kMostFaces;  // fixed, so that the parts do not depend on the number of threads

}  // namespace

// Faces in parts of a fixed size. A worker takes one stretch of parts after the other; the sweep's scratch
// lives as long as the stretch.
std::span<FaceOutput> ExactHull::sweep_faces(std::int32_t faces, int threads) {
  const std::size_t parts = static_cast<std::size_t>((faces + kFacesPerPart - 1) / kFacesPerPart);
  parts_.resize(std::max(parts_.size(), parts));
  input_.most_relations = kMostRelations / static_cast<std::int64_t>(std::max<std::size_t>(1, parts));
  const std::size_t stretches = threads == 1 ? 1 : std::min<std::size_t>(parts, 32);
  sweeps_.resize(std::max(sweeps_.size(), stretches));
  parallel_for(stretches, threads, [&](std::size_t stretch) {
    FaceSweep& sweep = sweeps_[stretch];
    sweep.start(input_);
    for (std::size_t p = parts * stretch / stretches; p < parts * (stretch + 1) / stretches; ++p) {
      FaceOutput& part = parts_[p];
      part.clear();
      const std::int32_t end =
          std::min<std::int32_t>(faces, static_cast<std::int32_t>((p + 1) * kFacesPerPart));
      for (std::int32_t face = static_cast<std::int32_t>(p) * kFacesPerPart; face < end;) {
        const auto next = std::upper_bound(input_.first_face.begin(), input_.first_face.end(), face);
        const std::int32_t stop = next == input_.first_face.end() ? end : std::min(end, *next);
        sweep.run(static_cast<int>(next - input_.first_face.begin()) - 1, face - *(next - 1),
                  stop - *(next - 1), part);
        face = stop;
      }
    }
  });
  return std::span(parts_).first(parts);
}

void ExactHull::attempt(std::span<const ConeView> views, const GridViews* grid, const ExactOptions& options,
                        ExactOutcome& outcome) {
  Stopwatch watch;
  ++outcome.attempts;
  outcome.closed = outcome.unbounded = false;
  polygons_.clear();
  std::int32_t faces = 0;
  input_.first_face.resize(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    input_.first_face[v] = faces;
    faces += static_cast<std::int32_t>(views[v].rays.size());
  }
  outcome.too_complex = faces >= (1 << VertexName::kFaceBits) || !pairs_.build(views, grid, options.threads);
  outcome.timings.pairs = watch.lap();
  if (outcome.too_complex) return;
  input_.votes.set(views, options.votes);
  find_ray_intervals(views, pairs_, grid, input_.votes, options.threads, rays_);
  outcome.timings.rays = watch.lap();

  input_.views = views;
  input_.pairs = &pairs_;
  input_.rays = &rays_;
  input_.grid = grid;
  input_.cull = options.cull;
  const std::span<FaceOutput> used = sweep_faces(faces, options.threads);
  outcome.timings.faces = watch.lap();

  bool tie = pairs_.tie() || rays_.tie;
  int defects = 0;
  outcome.unbounded = rays_.unbounded;
  outcome.work = {pairs_.hit_count(), 0, 0};
  for (const FaceOutput& part : used) {
    outcome.work.lines += part.lines;
    outcome.too_complex |= part.too_many;
    outcome.work.relations += part.relations;
    tie |= part.tie;
    defects += part.defects;
    outcome.unbounded |= part.unbounded;
  }
  outcome.tie = tie;
  outcome.defects = defects;
  outcome.unbounded &= !tie;
  if (outcome.too_complex) return;
  if (outcome.unbounded) return;
  welder_.weld(input_, used, polygons_);
  outcome.closed = !tie && defects == 0 && !outcome.unbounded && polygons_.closed();
  outcome.timings.weld = watch.lap();
  if (outcome.closed && options.triangulate)
    outcome.closed = welder_.triangulate(used, options.threads, polygons_);
  outcome.timings.triangles = watch.lap();
}

ExactOutcome ExactHull::compute(std::vector<ConeView>& views, const ExactOptions& options) {
  ExactOutcome outcome;
  polygons_.clear();
  FLOATSTAGE_CHECK(views.size() >= 2, "the exact hull needs two views");
  double size = 0;
  for (const ConeView& view : views) size = std::max(size, (view.center - views[0].center).norm());
  if (options.start == ExactLevel::Doubles) {
    attempt(views, nullptr, options, outcome);
    if (outcome.closed || outcome.too_complex) return outcome;
  }
  if (options.start <= ExactLevel::Jitter) {
    moved_ = views;
    perturb(moved_, {1, 1e-4 * options.pixel, 1e-9 * size});
    outcome.level = ExactLevel::Jitter;
    attempt(moved_, nullptr, options, outcome);
    if (outcome.closed || outcome.too_complex) {
      views.swap(moved_);
      return outcome;
    }
  }
  outcome.level = ExactLevel::Integers;
  double amount = 1e-4;  // px
  for (std::uint64_t seed = 2; seed < 8; ++seed, amount *= 2) {
    moved_ = views;
    perturb(moved_, {seed, amount * options.pixel, 1e-7 * size});
    if (!snap_to_grid(moved_, grid_)) continue;
    attempt(moved_, &grid_, options, outcome);
    if (outcome.closed || outcome.unbounded || outcome.too_complex) break;
  }
  views.swap(moved_);
  return outcome;
}

}  // namespace floatstage::recon
