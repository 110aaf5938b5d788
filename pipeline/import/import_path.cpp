#include "pipeline/import/import_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/import/gltf_camera.h"
#include "pipeline/import/media_files.h"

namespace floatstage::pipeline {
namespace {

constexpr double kPixel = 0.5;  // px that a principal point may lie off the middle without a word

bool fits_a_path(const CameraModel& m) {
  return std::holds_alternative<std::monostate>(m.lens) && m.skew == 0 &&
         std::abs(m.fx - m.fy) < 1e-3 * m.fy && std::abs(m.cx - m.width / 2.0) <= kPixel &&
         std::abs(m.cy - m.height / 2.0) <= kPixel;
}

Result<std::vector<FilmCamera>> of_colmap(const ImportPathOptions& options) {
  Result<calib::ForeignRig> model = calib::read_rig({"colmap", options.from, 1});
  if (!model) return forward(model);
  std::vector<std::size_t> order(model->rig.cameras.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return natural_less(model->image_names[a], model->image_names[b]);
  });
  std::vector<FilmCamera> cameras;
  bool fit = true;
  for (const std::size_t i : order) {
    const RigCamera& camera = model->rig.cameras[i];
    fit = fit && fits_a_path(camera.model);
    const double fov = 2 * std::atan(camera.model.height / (2 * camera.model.fy)) * 180 / std::numbers::pi;
    cameras.push_back(
        {static_cast<double>(cameras.size()) / options.frame_rate, camera.cam_from_world, fov, {}, {}});
  }
  if (!fit)
    log::info(text(options.from.string(),
                   ": a path's pictures have square pixels, no lens and their principal "
                   "point in the middle; what these have else is left out"));
  return cameras;
}

Result<std::vector<FilmCamera>> of_gltf(const ImportPathOptions& options) {
  const Result<std::string> bytes = read_file(options.from);
  if (!bytes) return forward(bytes);
  return parse_gltf_camera(*bytes, options.from.string(), options.from.parent_path(), options.z_up,
                           options.camera);
}

}  // namespace

Result<CameraPath> import_path(const ImportPathOptions& options) {
  if (!(options.frame_rate > 0)) return fail(ErrorCode::InvalidArgument, "--fps must be positive");
  const std::string kind = options.from.extension();
  if (!is_there(options.from)) return fail(ErrorCode::NotFound, text("there is no ", options.from.string()));
  const bool gltf = kind == ".gltf" || kind == ".glb";
  if (!gltf && !std::filesystem::is_directory(options.from))
    return fail(
        ErrorCode::InvalidArgument,
        text(options.from.string(), " is neither a .gltf or .glb nor a folder with COLMAP's cameras"));
  const Result<std::vector<FilmCamera>> cameras = gltf ? of_gltf(options) : of_colmap(options);
  if (!cameras) return forward(cameras);
  if (cameras->size() < 2)
    return fail(ErrorCode::InvalidArgument,
                text(options.from.string(), " shows the camera at one time only; a path needs two"));
  CameraPath path = path_through(*cameras);
  // What was read is what will be read: the same sentences for what a path cannot be.
  return parse_path(to_json(path), options.from.string());
}

}  // namespace floatstage::pipeline
