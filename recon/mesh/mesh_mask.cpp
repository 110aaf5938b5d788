#include "recon/mesh/mesh_mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Both orientations, edges included: neighbours overlap rather than leave a seam. Row by row, because the
// triangles of an exact hull are long and thin.
void fill(const std::array<Vector2d, 3>& t, Image& mask) {
  const Vector2d lo = t[0].cwiseMin(t[1]).cwiseMin(t[2]), hi = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  const double width = mask.width, height = mask.height;
  if (!t[0].allFinite() || !t[1].allFinite() || !t[2].allFinite()) return;
  if (!(hi.x() >= 0.5 && hi.y() >= 0.5 && lo.x() <= width - 0.5 && lo.y() <= height - 0.5)) return;
  const int y0 = static_cast<int>(std::ceil(std::max(lo.y() - 0.5, 0.0)));
  const int y1 = static_cast<int>(std::floor(std::min(hi.y() - 0.5, height - 1)));
  for (int y = y0; y <= y1; ++y) {
    const double row = y + 0.5;
    double left = hi.x(), right = lo.x();
    for (int k = 0; k < 3; ++k) {
      const Vector2d &a = t[k], &b = t[(k + 1) % 3];
      if ((a.y() < row && b.y() < row) || (a.y() > row && b.y() > row)) continue;
      const double x = a.y() == b.y() ? a.x() : a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      left = std::min({left, x, a.y() == b.y() ? b.x() : x});
      right = std::max({right, x, a.y() == b.y() ? b.x() : x});
    }
    // What is cut off just before the camera reaches further to the sides than integers do.
    const int x0 = static_cast<int>(std::ceil(std::clamp(left - 0.5, 0.0, width)));
    const int x1 = static_cast<int>(std::floor(std::clamp(right - 0.5, -1.0, width - 1)));
    if (x0 <= x1) std::fill(mask.at(x0, y), mask.at(x1, y) + 1, std::uint8_t{255});
  }
}

// The part of a triangle (camera coordinates) in front of the camera, as a fan.
void fill_cut(const CameraModel& model, const std::array<Vector3d, 3>& t, double near, Image& mask) {
  std::vector<Vector2d> polygon;
  auto add = [&](const Vector3d& p) {
    if (const std::optional<Vector2d> pixel = project(model, p)) polygon.push_back(*pixel);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d &a = t[i], &b = t[(i + 1) % 3];
    if (a.z() >= near) add(a);
    if ((a.z() >= near) != (b.z() >= near)) add(a + (b - a) * ((near - a.z()) / (b.z() - a.z())));
  }
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) fill({polygon[0], polygon[i], polygon[i + 1]}, mask);
}

}  // namespace

Matte mesh_mask(const RigCamera& camera, const Mesh& mesh) {
  Image mask(camera.model.width, camera.model.height, 1);
  std::vector<Vector3d> in_camera;
  std::vector<std::optional<Vector2d>> pixels;
  in_camera.reserve(mesh.positions.size());
  pixels.reserve(mesh.positions.size());
  double farthest = 0;
  for (const Eigen::Vector3f& p : mesh.positions) {
    in_camera.push_back(camera.cam_from_world * p.cast<double>());
    farthest = std::max(farthest, in_camera.back().z());
    pixels.push_back(project(camera.model, in_camera.back()));
  }
  const double near = 1e-4 * farthest;
  for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
    const std::uint32_t a = mesh.triangles[i], b = mesh.triangles[i + 1], c = mesh.triangles[i + 2];
    const auto depths = std::minmax({in_camera[a].z(), in_camera[b].z(), in_camera[c].z()});
    if (depths.second <= near) continue;
    if (depths.first < near)
      fill_cut(camera.model, {in_camera[a], in_camera[b], in_camera[c]}, near, mask);
    else if (pixels[a] && pixels[b] && pixels[c])
      fill({*pixels[a], *pixels[b], *pixels[c]}, mask);
  }
  FrameInfo source;
  return make_matte(source, mask);
}

}  // namespace floatstage::recon
