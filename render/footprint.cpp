#include "render/footprint.h"

#include <limits>

namespace floatstage::render {

// A pixel is seen under at most 1/f; on the surface its shorter axis is at most z_v/f_v long, and the
// photograph shows a length L on at most L f / (z cos) pixels. z_v/z is a ratio of linear functions and the
// secant grows away from the axis: both are largest in corners of the box.
int deepest_level(const RigCamera& camera, const View& view, const Eigen::AlignedBox3f& box) {
  double depths = 0, secant = 1;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i)).cast<double>();
    const Eigen::Vector3d there = camera.cam_from_world * corner;
    if (!(there.z() > 0)) return kLastLevel;
    depths = std::max(depths, (view.view_from_world * corner).z() / there.z());
    secant = std::max(secant, there.norm() / there.z());
  }
  const double scale = std::max(camera.model.fx, camera.model.fy) / std::min(view.model.fx, view.model.fy);
  const double widest = scale * depths * secant;
  const LevelMix mix = level_mix(static_cast<float>(widest * widest));
  return mix.level + (mix.next > 0 ? 1 : 0);
}

}  // namespace floatstage::render
