#include "pipeline/export/export_mesh.h"

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/export/instant.h"
#include "pipeline/export/refine_mesh.h"
#include "pipeline/export/surface_sights.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// How wide a pixel of the photograph that shows the subject largest is on it, metres.
double finest_pixel(const StraightInstant& instant) {
  const Eigen::Vector3d middle = bounding_box(instant.mesh).center().cast<double>();
  double finest = std::numeric_limits<double>::infinity();
  for (const RigCamera& camera : instant.rig.cameras)
    finest = std::min(finest, (camera.cam_from_world.center() - middle).norm() /
                                  std::max(camera.model.fx, camera.model.fy));
  return finest;
}

double area_of(const Mesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const Eigen::Vector3f &a = mesh.positions[mesh.triangles[t]], &b = mesh.positions[mesh.triangles[t + 1]],
                          &c = mesh.positions[mesh.triangles[t + 2]];
    area += 0.5 * static_cast<double>((b - a).cross(c - a).norm());
  }
  return area;
}

Result<ColoredMesh> colored(const StraightInstant& instant, double spacing, double& metres) {
  if (instant.mesh.empty()) return ColoredMesh{};
  metres = spacing * finest_pixel(instant);
  // Triangles of halved sides are at least a quarter of the largest that fits.
  const double expected = 4 * area_of(instant.mesh) / (0.25 * std::numbers::sqrt3 * metres * metres);
  if (expected > static_cast<double>(kMostTriangles))
    return fail(ErrorCode::InvalidArgument, text("vertices ", spacing, " px apart would be ", expected,
                                                 " triangles; say a larger --spacing"));
  const SurfaceSights sights(instant);
  ColoredMesh out{refined(instant.mesh, metres), {}};
  out.colors = colors_of_vertices(instant, sights, out.mesh);
  return out;
}

// Calls `use` with each frame's coloured mesh, in order.
Result<ExportMeshReport> each_frame(const ExportMeshOptions& options,
                                    const std::function<Result<void>(int, double, ColoredMesh)>& use) {
  Result<std::unique_ptr<capture::TakeReader>> take = open_chosen(options.take, options.labels);
  if (!take) return forward(take);
  const double rate = (*take)->manifest().frame_rate > 0 ? (*take)->manifest().frame_rate : 25;
  SceneLoader loader(**take, true);
  ExportMeshReport report;
  report.spacing = std::numeric_limits<double>::infinity();
  ProgressPart progress(options.progress, "meshes", options.frames.size());
  for (const int frame : options.frames) {
    if (is_cancelled(options.progress)) return cancelled_unwritten();
    const Result<StraightInstant> instant = load_straight_instant(**take, loader, frame);
    if (!instant) return forward(instant);
    double metres = report.spacing;
    Result<ColoredMesh> mesh = colored(*instant, options.spacing, metres);
    if (!mesh) return fail(mesh.error().code, text("frame ", frame, ": ", mesh.error().message));
    report.spacing = std::min(report.spacing, metres);
    ++report.frames;
    report.vertices += mesh->mesh.positions.size();
    report.triangles += mesh->mesh.triangle_count();
    if (Result<void> ok = use(frame, rate, std::move(*mesh)); !ok) return forward(ok);
    progress.advance();
  }
  return report;
}

Result<ExportMeshReport> animated_file(const ExportMeshOptions& options) {
  if (is_there(options.out))
    return fail(ErrorCode::AlreadyExists,
                text(options.out.string(), ": is there already, and is left as it is; give another --out"));
  std::vector<ColoredMesh> frames;
  double frame_rate = 0;
  Result<ExportMeshReport> report = each_frame(options, [&](int, double rate, ColoredMesh mesh) {
    frame_rate = rate;
    frames.push_back(std::move(mesh));
    return Result<void>();
  });
  if (!report) return report;
  if (Result<void> ok = save_glb(frames, frame_rate, options.up, options.out); !ok) return forward(ok);
  return report;
}

Result<ExportMeshReport> folder_of_files(const ExportMeshOptions& options) {
  Result<UnfinishedFolder> out = UnfinishedFolder::begin(options.out);
  if (!out) return forward(out);
  Result<ExportMeshReport> report = each_frame(options, [&](int frame, double rate, const ColoredMesh& mesh) {
    char name[24] = "";
    std::snprintf(name, sizeof name, "%06d.glb", frame);
    return save_glb(std::span(&mesh, 1), rate, options.up, out->folder() / name);
  });
  if (!report) return report;
  if (Result<void> ok = out->publish(); !ok) return forward(ok);
  return report;
}

}  // namespace

Result<ExportMeshReport> export_mesh(const ExportMeshOptions& options) {
  if (options.frames.empty()) return fail(ErrorCode::InvalidArgument, "there is no frame to export");
  if (!(options.spacing > 0) || !std::isfinite(options.spacing))
    return fail(ErrorCode::InvalidArgument, "vertices stand more than 0 px apart; say another --spacing");
  const fs::path extension = options.out.extension();
  if (extension == ".glb") return animated_file(options);
  if (extension.empty()) return folder_of_files(options);
  return fail(ErrorCode::InvalidArgument,
              text(options.out.string(), ": name a .glb for one animated file, or a folder"));
}

}  // namespace floatstage::pipeline
