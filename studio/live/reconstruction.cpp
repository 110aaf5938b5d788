#include "studio/live/reconstruction.h"

#include <algorithm>

#include "core/text.h"

namespace floatstage::studio {

Result<void> Reconstruction::make(std::span<const std::shared_ptr<const CameraView>> views, int threads,
                                  StudioScene& scene) {
  scene.epoch = 0;
  scene.instant = scene.produced = {};
  scene.rig_sha256 = rig_sha256_;
  scene.remark.clear();
  scene.mesh.positions.clear();
  scene.mesh.triangles.clear();
  outlines_.resize(rig_.cameras.size());
  for (Silhouette& outline : outlines_) outline.clear();
  remark_.clear();
  std::size_t known = 0;
  for (const std::shared_ptr<const CameraView>& view : views) {
    const int camera = view ? camera_index(rig_, view->serial) : -1;
    if (camera < 0) continue;
    const CameraModel& model = rig_.cameras[static_cast<std::size_t>(camera)].model;
    if (view->width != model.width || view->height != model.height)
      return fail(
          ErrorCode::InvalidArgument,
          text("camera '", view->serial, "' sends outlines of ", view->width, "x", view->height,
               " pictures and was calibrated at ", model.width, "x", model.height, "; set that size"));
    scene.epoch = std::max(scene.epoch, view->epoch);
    scene.instant = view->instant;
    if (!view->known) continue;
    scene.produced = known > 0 ? std::min(scene.produced, view->produced) : view->produced;
    scene.cameras.resize(std::max(scene.cameras.size(), known + 1));  // those there keep their strings
    scene.cameras[known].serial = view->serial;
    scene.cameras[known++].exposed = view->exposed;
    outlines_[static_cast<std::size_t>(camera)] = view->outline;
  }
  scene.cameras.resize(known);
  recon::HullOptions options;
  options.threads = threads;
  options.quality = false;
  const Result<void> hull =
      recon::visual_hull(rig_, std::span<const Silhouette>(outlines_), options, workspace_, report_);
  if (!hull && hull.error().code != ErrorCode::BadData) return forward(hull);
  if (hull) {
    std::swap(scene.mesh, report_.mesh);
    if (!report_.remarks.empty()) remark_ = report_.remarks.front();
  } else {
    remark_ = hull.error().message;
  }
  return {};
}

}  // namespace floatstage::studio
