#include "recon/visual_hull.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "core/text.h"
#include "recon/bounding_volume.h"
#include "recon/exact/exact_method.h"
#include "recon/hull_input.h"
#include "recon/mesh/hull_cleanup.h"
#include "recon/mesh/mesh_cleanup.h"
#include "recon/mesh/mesh_silhouettes.h"
#include "recon/octree/octree_carve.h"
#include "recon/octree/octree_surface.h"
#include "recon/small_budget.h"

namespace floatstage::recon {
namespace {

// Which cameras show no subject, in words; an error when none shows any.
Result<std::vector<std::string>> remark_on_subjects(const Rig& rig, const HullInput& input) {
  std::vector<std::string> remarks;
  bool any = false;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    if (!input.knows(i)) continue;
    if (!input.shows_subject(i))
      remarks.push_back(
          text("camera '", rig.cameras[i].serial, "' sees only background and carves all that it sees"));
    else
      any = true;
  }
  if (!any)
    return fail(ErrorCode::BadData,
                "empty silhouette: no camera shows any subject; check the mattes of this frame");
  return remarks;
}

Result<Eigen::AlignedBox3d> search_box(const Rig& rig, std::span<const Matte> mattes,
                                       const HullOptions& options, std::span<const OctreeView> views) {
  if (options.volume) return *options.volume;
  const std::optional<Eigen::AlignedBox3d> box = bounding_volume(rig, mattes);
  if (!box)
    return fail(
        ErrorCode::BadData,
        "the silhouettes bound nothing: in too many cameras the subject fills the image or is cut by its "
        "border; give the volume to search");
  return box->isEmpty() ? *box : shrink_to_hull(views, *box);
}

Mesh to_mesh(const Surface& surface) {
  Mesh mesh;
  mesh.positions.reserve(surface.positions.size());
  for (const Eigen::Vector3d& p : surface.positions) mesh.positions.emplace_back(p.cast<float>());
  mesh.triangles.reserve(3 * surface.triangles.size());
  for (const auto& t : surface.triangles) mesh.triangles.insert(mesh.triangles.end(), t.begin(), t.end());
  return mesh;
}

/// The octree method, for inputs that were checked.
Result<void> octree_visual_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                                HullReport& report) {
  std::vector<std::optional<OctreeView>> prepared(mattes.size());
  parallel_for(mattes.size(), options.threads, [&](std::size_t i) {
    if (!mattes[i].empty()) prepared[i].emplace(rig.cameras[i], mattes[i]);
  });
  std::vector<OctreeView> views;
  for (std::optional<OctreeView>& view : prepared)
    if (view) views.push_back(std::move(*view));

  const Result<Eigen::AlignedBox3d> box = search_box(rig, mattes, options, views);
  if (!box) return forward(box);
  report.searched = *box;
  if (!box->isEmpty()) {
    const CarvedGrid grid = carve(views, *box, options.resolution, options.threads);
    report.voxel = grid.voxel();
    const CleanupOptions cleanup{grid.voxel(), options.smoothing, options.threads};
    report.mesh = to_mesh(clean_up(extract_surface(grid, views, options.threads), cleanup));
  }
  report.volume = signed_volume(report.mesh);
  return {};
}

/// Whether there are as many cameras as are asked to agree, and enough to bound a body.
Result<void> check_cameras(const Rig& rig, const HullInput& input, const HullOptions& options) {
  const std::size_t cameras = rig.cameras.size();
  if (options.voting == HullVoting::MofN && static_cast<std::size_t>(options.votes) > cameras)
    return fail(ErrorCode::InvalidArgument,
                text("hull: ", options.votes, " cameras cannot agree where there are ", cameras, "; ask for ",
                     cameras, " at most, or for strict votes"));
  std::size_t known = 0, last = 0;
  for (std::size_t c = 0; c < cameras; ++c)
    if (input.knows(c)) ++known, last = c;
  if (known != 1 || options.volume) return {};
  return fail(ErrorCode::BadData,
              text("only camera '", rig.cameras[last].serial,
                   "' shows a silhouette, which bounds a cone without an end; add cameras, or "
                   "give the volume to search"));
}

/// visual_hull() of either input.
Result<void> hull_of(const Rig& rig, HullInput input, const HullOptions& options, HullWorkspace& workspace,
                     HullReport& report) {
  const auto begin = std::chrono::steady_clock::now();
  report.clear();
  if (Result<void> ok = check(options); !ok) return forward(ok);
  if (Result<void> ok = check(rig); !ok) return forward(ok);
  if (Result<void> ok = input.check(workspace.impl().polygons); !ok) return forward(ok);
  if (Result<void> ok = check_cameras(rig, input, options); !ok) return forward(ok);
  Result<std::vector<std::string>> remarks = remark_on_subjects(rig, input);
  if (!remarks) return forward(remarks);

  report.remarks = std::move(*remarks);
  bool octree = options.method == HullMethod::Octree;
  if (!octree) {
    const Result<bool> closed = exact_visual_hull(rig, input, options, workspace.impl(), report);
    if (!closed) return forward(closed);
    if (!*closed) {
      if (input.outlined()) {  // they come live, and an octree takes seconds
        report.clear();
        return fail(ErrorCode::BadData,
                    "the exact hull of these outlines did not close: leave the frame out, and look at what "
                    "sends them");
      }
      report.remarks.emplace_back(
          "the exact hull did not close: the octree made this one; please report the frame");
      octree = true;
    }
  }
  if (octree) {
    if (Result<void> ok = octree_visual_hull(rig, input.mattes(), options, report); !ok) return forward(ok);
  }
  if (report.mesh.empty())
    report.remarks.emplace_back("no point of space is inside every silhouette: the hull is empty");

  if (options.cleanup.wanted() && !report.mesh.empty()) {
    const Mesh raw = options.cleanup.triangles > 0 ? report.mesh : Mesh();
    clean_up_hull(rig, input.mattes(), options, report);
    if (report.cleanup && options.cleanup.triangles > 0)
      if (Result<void> ok = meet_budget(rig, input.mattes(), options, raw, report); !ok) return ok;
  }

  const auto quality = std::chrono::steady_clock::now();
  report.silhouette_iou.assign(rig.cameras.size(), std::numeric_limits<double>::quiet_NaN());
  if (options.quality) {
    const std::span<const Matte> mattes = input.mattes();
    const MeshSilhouettes silhouettes(report.mesh);
    parallel_for(mattes.size(), options.threads, [&](std::size_t i) {
      if (!mattes[i].empty())
        report.silhouette_iou[i] = silhouettes.iou(rig.cameras[i], mattes[i], options.quality_step);
    });
  }
  const auto end = std::chrono::steady_clock::now();
  report.timings.quality = std::chrono::duration<double>(end - quality).count();
  report.seconds = std::chrono::duration<double>(end - begin).count();
  return {};
}

template <class Given>
Result<HullReport> fresh_hull(const Rig& rig, std::span<const Given> given, const HullOptions& options,
                              HullWorkspace* workspace) {
  std::optional<HullWorkspace> own;
  HullReport report;
  if (Result<void> ok = visual_hull(rig, given, options, workspace ? *workspace : own.emplace(), report); !ok)
    return forward(ok);
  return report;
}

}  // namespace

HullWorkspace::HullWorkspace() : impl_(std::make_unique<Impl>()) {}
HullWorkspace::HullWorkspace(HullWorkspace&&) noexcept = default;
HullWorkspace& HullWorkspace::operator=(HullWorkspace&&) noexcept = default;
HullWorkspace::~HullWorkspace() = default;

Result<void> check(const HullOptions& o) {
  auto bad = [](const std::string& what) { return fail(ErrorCode::InvalidArgument, "hull: " + what); };
  if (o.resolution < 8 || o.resolution > 1024)
    return bad(text("a resolution of ", o.resolution, " voxels is not between 8 and 1024"));
  if (!(o.smoothing >= 0 && o.smoothing <= 1))
    return bad(text("smoothing by ", o.smoothing, " voxels is not between 0 and 1"));
  if (!(o.contour_tolerance >= 0 && o.contour_tolerance <= 16))
    return bad(text("a contour tolerance of ", o.contour_tolerance, " px is not between 0 and 16"));
  if (o.quality_step < 1 || o.quality_step > 64)
    return bad(text("quality on every ", o.quality_step, "th row is not between 1 and 64"));
  if (o.votes < 0 || (o.voting == HullVoting::MofN && o.votes < 2))
    return bad(text(o.votes, " votes are too few: at least two cameras have to agree"));
  if (o.cleanup.smooth < 0 || o.cleanup.smooth > 1000)
    return bad(text("cleanup by ", o.cleanup.smooth, " rounds of smoothing is not between 0 and 1000"));
  if (!(o.cleanup.largest_move >= 0 && o.cleanup.largest_move <= 64))
    return bad(text("a largest move of ", o.cleanup.largest_move, " px is not between 0 and 64"));
  if (!(o.cleanup.largest_loss >= 0 && o.cleanup.largest_loss <= 1))
    return bad(text("a largest loss of ", o.cleanup.largest_loss, " is no share between 0 and 1"));
  if (o.cleanup.triangles != 0 && o.cleanup.triangles < 4)
    return bad(text("a budget of ", o.cleanup.triangles,
                    " triangles closes no surface: give at least 4, or 0 for none"));
  if (o.volume && !(o.volume->min().allFinite() && o.volume->max().allFinite() &&
                    (o.volume->min().array() < o.volume->max().array()).all()))
    return bad("the volume to search is not a box with finite corners and positive sides");
  return {};
}

void HullReport::clear() {
  HullReport fresh;
  fresh.mesh = std::move(mesh);
  fresh.mesh.positions.clear();
  fresh.mesh.triangles.clear();
  fresh.silhouette_iou = std::move(silhouette_iou);
  fresh.sources = std::move(sources);
  fresh.sources.clear();
  *this = std::move(fresh);
}

Result<HullReport> visual_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                               HullWorkspace* workspace) {
  return fresh_hull(rig, mattes, options, workspace);
}

Result<HullReport> visual_hull(const Rig& rig, std::span<const Silhouette> outlines,
                               const HullOptions& options, HullWorkspace* workspace) {
  return fresh_hull(rig, outlines, options, workspace);
}

Result<void> visual_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                         HullWorkspace& workspace, HullReport& report) {
  return hull_of(rig, HullInput(rig, mattes, options.threads), options, workspace, report);
}

Result<void> visual_hull(const Rig& rig, std::span<const Silhouette> outlines, const HullOptions& options,
                         HullWorkspace& workspace, HullReport& report) {
  return hull_of(rig, HullInput(rig, outlines, options.threads), options, workspace, report);
}

}  // namespace floatstage::recon
