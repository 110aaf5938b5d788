#include "render/depth_windows.h"

#include <algorithm>
#include <cmath>

#include "render/camera_block.h"

namespace floatstage::render {
namespace {

constexpr double kGuardPixels = 4;  // around the picture: the test at its border reads a full neighbourhood
constexpr int kLargestSide = 2048;  // texels
constexpr double kToleranceShare = 0.0125;  // of the proxy's diagonal

}  // namespace

DepthWindow depth_window(const RigCamera& camera, const Eigen::AlignedBox3f& box) {
  const Eigen::Vector3d middle = box.center().cast<double>();
  const double radius = 0.5 * static_cast<double>(box.diagonal().norm()) + 1e-6;
  const Eigen::AlignedBox2d bounds = pinhole_bounds(camera, box, kGuardPixels);
  const Eigen::Vector2d extent = bounds.sizes();
  const double scale = std::min(
      {std::max(camera.model.fx, camera.model.fy), kLargestSide / extent.x(), kLargestSide / extent.y()});
  DepthWindow w;
  w.width = std::max(2, static_cast<int>(std::ceil(extent.x() * scale)));
  w.height = std::max(2, static_cast<int>(std::ceil(extent.y() * scale)));
  const Eigen::Vector2d offset = -bounds.min() * scale;
  w.place = {static_cast<float>(scale), static_cast<float>(scale), static_cast<float>(offset.x()),
             static_cast<float>(offset.y())};
  const double z = (camera.cam_from_world * middle).z();
  w.far_plane = static_cast<float>(std::max(z + radius, radius));
  w.near_plane = static_cast<float>(std::max(z - radius, 1e-3 * radius));
  return w;
}

double depth_tolerance(const Eigen::AlignedBox3f& box) {
  return kToleranceShare * static_cast<double>(box.diagonal().norm());
}

}  // namespace floatstage::render
