#include "pipeline/export/export_colmap.h"

#include <cstdio>

#include "calib/colmap_model.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/export/instant.h"
#include "pipeline/export/surface_sights.h"
#include "pipeline/export/transforms_json.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewestSights = 2;  // what triangulation means

Image with_alpha(const Image& rgb, const Image& alpha) {
  Image out(rgb.width, rgb.height, 4);
  for (std::size_t p = 0; p < alpha.pixels.size(); ++p) {
    std::copy_n(&rgb.pixels[3 * p], 3, &out.pixels[4 * p]);
    out.pixels[4 * p + 3] = alpha.pixels[p];
  }
  return out;
}

Result<PicturePaths> save_pictures(const StraightInstant& instant, bool alpha, const fs::path& folder) {
  for (const char* name : {"images", "masks"})
    if (Result<void> ok = make_folder(folder / name); !ok) return forward(ok);
  PicturePaths paths;
  paths.points = "points.ply";
  for (std::size_t i = 0; i < instant.pictures.size(); ++i) {
    const std::string name = instant.rig.cameras[i].serial + ".png";
    paths.pictures.push_back("images/" + name);
    paths.mattes.push_back(instant.mattes[i].empty() ? "" : "masks/" + name + ".png");
  }
  std::vector<Result<void>> saved(instant.pictures.size());
  parallel_for(saved.size(), 0, [&](std::size_t i) {
    const Image &picture = instant.pictures[i], &matte = instant.mattes[i];
    const bool joined = alpha && !matte.empty();
    saved[i] = save_png(joined ? with_alpha(picture, matte) : picture, folder / paths.pictures[i]);
    if (saved[i] && !matte.empty()) saved[i] = save_png(matte, folder / paths.mattes[i]);
  });
  for (const Result<void>& ok : saved)
    if (!ok) return forward(ok);
  return paths;
}

std::vector<calib::ColmapPoint> points_of(const StraightInstant& instant) {
  const SurfaceSights sights(instant);
  const std::vector<Rgb> colors = colors_of_vertices(instant, sights, instant.mesh);
  std::vector<calib::ColmapPoint> points;
  for (std::size_t v = 0; v < instant.mesh.positions.size(); ++v) {
    const Eigen::Vector3d position = instant.mesh.positions[v].cast<double>();
    std::size_t seen = 0;
    for (std::size_t c = 0; c < instant.rig.cameras.size(); ++c) seen += sights.see(c, position) ? 1 : 0;
    if (seen >= kFewestSights) points.push_back({position, colors[v]});
  }
  return points;
}

std::string ply_of(const std::vector<calib::ColmapPoint>& points) {
  std::string ply = text("ply\nformat binary_little_endian 1.0\nelement vertex ", points.size(),
                         "\nproperty float x\nproperty float y\nproperty float z\n"
                         "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n");
  for (const calib::ColmapPoint& point : points) {
    const Eigen::Vector3f p = point.position.cast<float>();
    ply.append(reinterpret_cast<const char*>(p.data()), sizeof p);
    ply.append(reinterpret_cast<const char*>(point.color.data()), point.color.size());
  }
  return ply;
}

Result<void> write_instant(const StraightInstant& instant, bool alpha, const fs::path& folder,
                           ExportColmapReport& report) {
  const Result<PicturePaths> paths = save_pictures(instant, alpha, folder);
  if (!paths) return forward(paths);
  const std::vector<calib::ColmapPoint> points = points_of(instant);
  std::vector<std::string> names;
  for (const RigCamera& camera : instant.rig.cameras) names.push_back(camera.serial + ".png");
  if (Result<void> ok = calib::write_colmap_model(instant.rig, names, points, folder / "sparse" / "0"); !ok)
    return ok;
  if (Result<void> ok = write_file(folder / "points.ply", ply_of(points)); !ok) return ok;
  if (Result<void> ok = write_file(folder / "transforms.json", transforms_json(instant.rig, *paths)); !ok)
    return ok;
  ++report.frames;
  report.pictures += static_cast<int>(names.size());
  for (const std::string& matte : paths->mattes) report.masks += matte.empty() ? 0 : 1;
  report.points += points.size();
  return {};
}

}  // namespace

Result<ExportColmapReport> export_colmap(const ExportColmapOptions& options) {
  if (options.frames.empty()) return fail(ErrorCode::InvalidArgument, "there is no frame to export");
  Result<std::unique_ptr<capture::TakeReader>> take = open_chosen(options.take, options.labels);
  if (!take) return forward(take);
  Result<UnfinishedFolder> out = UnfinishedFolder::begin(options.out);
  if (!out) return forward(out);
  SceneLoader loader(**take, true);
  ExportColmapReport report;
  ProgressPart progress(options.progress, "frames", options.frames.size());
  for (const int frame : options.frames) {
    if (is_cancelled(options.progress)) return cancelled_unwritten();
    const Result<StraightInstant> instant = load_straight_instant(**take, loader, frame, options.cameras);
    if (!instant) return forward(instant);
    char name[16] = "";
    if (options.frames.size() > 1) std::snprintf(name, sizeof name, "%06d", frame);
    if (Result<void> ok = write_instant(*instant, options.alpha, out->folder() / name, report); !ok)
      return forward(ok);
    progress.advance();
  }
  if (Result<void> ok = out->publish(); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
