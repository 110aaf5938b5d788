#include "recon/exact/silhouette_cones.h"

#include <algorithm>

#include "core/parallel.h"

namespace floatstage::recon {
namespace {

/// Whether the whole box lies in the picture. Its corners decide: a frustum is convex, and lenses bend
/// little.
bool sees_all(const RigCamera& camera, const Eigen::AlignedBox3d& box) {
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(c));
    const auto pixel = project(camera.model, camera.cam_from_world * corner);
    if (!pixel || !inside(camera.model, *pixel)) return false;
  }
  return true;
}

void append_rays(const RigCamera& camera, const Silhouette& outline, ConeView& view) {
  view.clear();
  view.center = camera.cam_from_world.center();
  view.beyond_counts = outline.beyond_counts;
  const Eigen::Matrix3d world_from_pixel =
      camera.cam_from_world.rotation.conjugate().toRotationMatrix() * pinhole(camera.model).k().inverse();
  for (int k = 0; k < outline.polygons(); ++k) {
    const int begin = outline.starts[k], end = outline.starts[k + 1];
    view.add_loop(static_cast<std::size_t>(end - begin), [&](std::size_t p) -> Eigen::Vector3d {
      return world_from_pixel * outline.points[static_cast<std::size_t>(begin) + p].homogeneous();
    });
  }
}

}  // namespace

void add_volume(const Eigen::AlignedBox3d& box, SilhouetteCones& cones) {
  for (ConeView& view : volume_views(box)) {
    cones.views.push_back(std::move(view));
    cones.camera.push_back(-1);
  }
}

void ConeBuilder::build(const Rig& rig, const HullInput& input, const ConeOptions& options,
                        SilhouetteCones& out) {
  const std::size_t count = rig.cameras.size();
  scratch_.resize(count);
  tables_.resize(count);
  out.outlines.resize(count);
  out.details.resize(count);
  parallel_for(count, options.threads, [&](std::size_t c) {
    CameraTable& table = tables_[c];
    if (!(table.model == rig.cameras[c].model))
      table = {rig.cameras[c].model, lens_bend(rig.cameras[c].model)};
    SilhouetteOptions settings;
    settings.tolerance = options.tolerance;
    settings.unknown_beyond = options.partial.empty()
                                  ? options.volume && !sees_all(rig.cameras[c], *options.volume)
                                  : options.partial[c] != 0;
    settings.smallest = options.smallest;
    settings.most_points = options.most_points;
    const Silhouette* given = input.outline(c);
    out.details[c] =
        given ? undistorted_outline(*given, table.model, table.bend, settings, scratch_[c], out.outlines[c])
              : undistorted_outline(input.matte(c), table.model, table.bend, settings, scratch_[c],
                                    out.outlines[c]);
  });
  std::size_t used = 0;
  out.camera.clear();
  out.pixel = 1;
  for (std::size_t c = 0; c < count; ++c) {
    if (out.outlines[c].empty()) continue;
    if (out.views.size() <= used) out.views.emplace_back();
    append_rays(rig.cameras[c], out.outlines[c], out.views[used++]);
    out.camera.push_back(static_cast<int>(c));
    out.pixel = std::min(out.pixel, 1 / std::max(rig.cameras[c].model.fx, rig.cameras[c].model.fy));
  }
  out.views.resize(used);
  if (options.volume) add_volume(*options.volume, out);
}

}  // namespace floatstage::recon
