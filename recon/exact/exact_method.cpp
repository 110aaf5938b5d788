#include "recon/exact/exact_method.h"

#include <algorithm>
#include <chrono>

#include "core/text.h"
#include "recon/bounding_volume.h"
#include "recon/exact/exact_voting.h"

namespace floatstage::recon {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Unexpected unbounded() {
  return fail(
      ErrorCode::BadData,
      "the silhouettes bound nothing: in too many cameras the subject fills the image or is cut by its "
      "border; give the volume to search");
}

/// Shells of which no camera sees anything are not hull: nothing bears witness for them.
void drop_unseen_shells(const Rig& rig, const HullInput& input, HullReport& report) {
  Mesh& mesh = report.mesh;
  std::vector<std::uint32_t> root(mesh.positions.size());
  for (std::uint32_t v = 0; v < root.size(); ++v) root[v] = v;
  const auto find = [&](std::uint32_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    root[find(mesh.triangles[t])] = find(mesh.triangles[t + 1]);
    root[find(mesh.triangles[t + 1])] = find(mesh.triangles[t + 2]);
  }
  constexpr double kMargin = 1;  // px
  std::vector<std::uint8_t> seen(root.size(), 0);
  for (std::uint32_t v = 0; v < root.size(); ++v) {
    for (std::size_t c = 0; c < rig.cameras.size() && !seen[find(v)]; ++c) {
      if (!input.knows(c)) continue;
      const CameraModel& model = rig.cameras[c].model;
      const auto pixel = project(model, rig.cameras[c].cam_from_world * mesh.positions[v].cast<double>());
      seen[find(v)] = pixel && pixel->x() > kMargin && pixel->y() > kMargin &&
                      pixel->x() < model.width - kMargin && pixel->y() < model.height - kMargin;
    }
  }
  Mesh kept;
  std::vector<HullFaceSource> sources;
  std::vector<std::int64_t> number(root.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    if (!seen[find(mesh.triangles[t])]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[t + k];
      if (number[v] < 0) {
        number[v] = static_cast<std::int64_t>(kept.positions.size());
        kept.positions.push_back(mesh.positions[v]);
      }
      kept.triangles.push_back(static_cast<std::uint32_t>(number[v]));
    }
    sources.push_back(report.sources[t / 3]);
  }
  if (kept.triangles.size() == mesh.triangles.size()) return;
  mesh = std::move(kept);
  report.sources = std::move(sources);
  report.volume = signed_volume(mesh);
}

void remark_on_noise(const Rig& rig, const HullInput& input, double tolerance, const SilhouetteCones& cones,
                     HullReport& report) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const OutlineDetail& detail = cones.details[c];
    if (!input.knows(c) || (!detail.coarser && detail.smallest <= 0)) continue;
    if (cones.outlines[c].empty()) {
      report.remarks.push_back(text("camera '", rig.cameras[c].serial,
                                    "': its matte is nothing but specks and was left out; look at it"));
    } else {
      report.remarks.push_back(
          text("camera '", rig.cameras[c].serial, "': its matte is noisy: its outline was taken within ",
               std::max(tolerance, detail.tolerance), " px, without islands and holes below ",
               detail.smallest, " px²; look at it"));
    }
  }
}

void take_over(const HullPolygons& polygons, const SilhouetteCones& cones, HullReport& report) {
  report.volume = polygons.volume;
  report.faces = static_cast<int>(polygons.polygon_start.size()) - 1;
  report.mesh.positions.resize(polygons.positions.size());
  std::transform(polygons.positions.begin(), polygons.positions.end(), report.mesh.positions.begin(),
                 [](const Eigen::Vector3d& p) { return p.cast<float>(); });
  report.mesh.triangles.assign(polygons.triangles.begin(), polygons.triangles.end());
  report.sources.resize(polygons.triangle_face.size());
  std::transform(polygons.triangle_face.begin(), polygons.triangle_face.end(), report.sources.begin(),
                 [&](int face) {
                   const HullPolygons::Face& f = polygons.faces[static_cast<std::size_t>(face)];
                   return HullFaceSource{cones.camera[static_cast<std::size_t>(f.view)], f.edge};
                 });
}

// The cones of the cameras' outlines. `cut`: some outlines are open; `empty`: nothing can be inside.
struct Cones {
  bool cut = false, empty = false;
};

Result<Cones> make_cones(const Rig& rig, HullInput& input, const HullOptions& options,
                         const ConeOptions& settings, HullWorkspace::Impl& workspace) {
  SilhouetteCones& cones = workspace.cones;
  workspace.builder.build(rig, input, settings, cones);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    if (!cones.details[c].torn) continue;
    return fail(ErrorCode::BadData,
                text("camera '", rig.cameras[c].serial,
                     "': without its lens, its outline crosses itself too badly to be mended; "
                     "check its calibration and where the outline comes from"));
  }
  Cones made;
  made.cut =
      std::any_of(cones.views.begin(), cones.views.end(), [](const ConeView& v) { return v.beyond_counts; });
  if (options.volume || (!made.cut && cones.views.size() >= 2)) return made;
  // Some silhouettes are open: what the others bound is where the hull is sought.
  const std::optional<Eigen::AlignedBox3d> box = bounding_volume(rig, input.mattes());
  if (!box) return unbounded();
  made.empty = box->isEmpty();
  if (made.empty) return made;
  const Eigen::Vector3d margin = 0.01 * box->sizes();
  add_volume({box->min() - margin, box->max() + margin}, cones);
  return made;
}

ExactOptions engine_options(const HullOptions& options) {
  ExactOptions engine;
  engine.threads = options.threads;
  engine.votes = options.voting == HullVoting::MofN ? options.votes : 0;
  return engine;
}

ExactOutcome compute(HullWorkspace::Impl& workspace, const HullOptions& options) {
  ExactOptions engine = engine_options(options);
  workspace.views = workspace.cones.views;
  engine.pixel = workspace.cones.pixel;
  return workspace.engine.compute(workspace.views, engine);
}

// Mattes of noise have outlines that cross each other millions of times: those are made coarser until the
// frame's time is bounded.
Result<Cones> compute_in_time(const Rig& rig, HullInput& input, const HullOptions& options, double tolerance,
                              HullWorkspace::Impl& workspace, ExactOutcome& outcome, HullReport& report) {
  ConeOptions settings;
  settings.tolerance = tolerance;
  settings.volume = options.volume;
  settings.threads = options.threads;
  constexpr int kRounds = 6;
  for (int round = 0;; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    const Result<Cones> cones = make_cones(rig, input, options, settings, workspace);
    if (!cones || cones->empty) return cones;
    report.timings.contours = seconds_since(begin);
    outcome = compute(workspace, options);
    if (!outcome.too_complex) return cones;
    if (round == kRounds) {
      return fail(
          ErrorCode::BadData,
          "the outlines of the mattes cross each other too often, even without small islands and holes: they "
          "are noise; look at the mattes and at the keyer's settings");
    }
    settings.tolerance = std::max(settings.tolerance, std::clamp(2 * settings.tolerance, 0.5, 4.0));
    settings.smallest = std::max(16.0, 16 * settings.smallest);
  }
}

// Leaves out the cameras whose mattes lack what all others show, and computes again without them. False when
// the rest is not closed.
bool vote_down(const Rig& rig, HullInput& input, const HullOptions& options, HullWorkspace::Impl& workspace,
               ExactOutcome& outcome, HullReport& report) {
  SilhouetteCones& cones = workspace.cones;
  const auto begin = std::chrono::steady_clock::now();  // its trials use the same engine
  report.voted_down = find_bad_views(rig, input, report.mesh, options.threads, workspace);
  report.timings.voting = seconds_since(begin);
  if (report.voted_down.empty()) return true;
  for (const int camera : report.voted_down) {
    const std::ptrdiff_t v =
        std::find(cones.camera.begin(), cones.camera.end(), camera) - cones.camera.begin();
    cones.views.erase(cones.views.begin() + v);
    cones.camera.erase(cones.camera.begin() + v);
    report.remarks.push_back(text("camera '", rig.cameras[static_cast<std::size_t>(camera)].serial,
                                  "' was voted down: its matte lacks what all others show; look at it"));
  }
  const ExactOutcome again = compute(workspace, options);
  if (again.unbounded || !again.closed) return false;
  outcome.attempts += again.attempts - 1;
  outcome.timings = again.timings;
  take_over(workspace.engine.polygons(), cones, report);
  return true;
}

void report_cost(const ExactOutcome& outcome, const SilhouetteCones& cones, HullReport& report) {
  report.escalations = outcome.attempts - 1;
  report.work = {0, outcome.work.hits, outcome.work.lines, outcome.work.relations};
  for (const Silhouette& outline : cones.outlines)
    report.work.points += static_cast<std::int64_t>(outline.points.size());
  report.timings.tables = outcome.timings.pairs;
  report.timings.rays = outcome.timings.rays;
  report.timings.faces = outcome.timings.faces;
  report.timings.weld = outcome.timings.weld;
  report.timings.triangles = outcome.timings.triangles;
}

}  // namespace

Result<bool> exact_visual_hull(const Rig& rig, HullInput& input, const HullOptions& options,
                               HullWorkspace::Impl& workspace, HullReport& report) {
  const double tolerance = input.outlined() ? 0 : options.contour_tolerance;
  ExactOutcome outcome;
  const Result<Cones> cones = compute_in_time(rig, input, options, tolerance, workspace, outcome, report);
  if (!cones) return forward(cones);
  if (cones->empty) return true;
  remark_on_noise(rig, input, tolerance, workspace.cones, report);
  if (outcome.unbounded) return unbounded();
  if (!outcome.closed) return false;
  take_over(workspace.engine.polygons(), workspace.cones, report);
  if (options.voting == HullVoting::Auto && !vote_down(rig, input, options, workspace, outcome, report))
    return false;
  report_cost(outcome, workspace.cones, report);
  if (cones->cut) drop_unseen_shells(rig, input, report);
  const Eigen::AlignedBox3f bounds = bounding_box(report.mesh);
  report.searched = options.volume
                        ? *options.volume
                        : Eigen::AlignedBox3d(bounds.min().cast<double>(), bounds.max().cast<double>());
  return true;
}

}  // namespace floatstage::recon
