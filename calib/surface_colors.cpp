#include "calib/surface_colors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace floatstage::calib {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int kMargin = 3;       // px between a sight and the next outline
constexpr int kWindow = 1;       // px to each side: what is averaged
constexpr double kRough = 0.06;  // spread of a window that is too rough

struct Corner {
  Eigen::Vector2d pixel;
  double depth = 0;
  bool seen = false;
};

Corner see(const RigCamera& camera, const Eigen::Vector3d& in_world) {
  const Eigen::Vector3d x = camera.cam_from_world * in_world;
  if (!(x.z() > 1e-6)) return {};
  const std::optional<Eigen::Vector2d> p = project(camera.model, x);
  if (!p) return {};
  return {*p, x.z(), true};
}

// Whether all pixels near by show the surface at about this depth.
bool well_inside(const std::vector<float>& depth, const CameraModel& m, int x, int y, double z) {
  if (x < kMargin || y < kMargin || x >= m.width - kMargin || y >= m.height - kMargin) return false;
  const double tolerance = 0.01 * z;
  for (int v = y - kMargin; v <= y + kMargin; ++v)
    for (int u = x - kMargin; u <= x + kMargin; ++u)
      if (!(std::abs(depth[static_cast<std::size_t>(v) * m.width + u] - z) <
            (u == x && v == y ? tolerance : 4 * tolerance)))
        return false;
  return true;
}

Eigen::Array3d bilinear(const Image& image, double x, double y) {
  const double u = x - 0.5, v = y - 0.5;
  const int x0 = static_cast<int>(std::floor(u)), y0 = static_cast<int>(std::floor(v));
  const double a = u - x0, b = v - y0;
  const auto rgb = [&](int i, int j) {
    const std::uint8_t* p = image.at(i, j);
    return Eigen::Array3d(p[0], p[1], p[2]);
  };
  return ((1 - b) * ((1 - a) * rgb(x0, y0) + a * rgb(x0 + 1, y0)) +
          b * ((1 - a) * rgb(x0, y0 + 1) + a * rgb(x0 + 1, y0 + 1))) /
         255;
}

// Around the very place, not around its pixel: half a pixel is a different colour on cloth.
std::optional<Eigen::Vector3d> smooth_mean(const Image& image, const Eigen::Vector2d& at) {
  Eigen::Array3d sum = Eigen::Array3d::Zero(), squares = Eigen::Array3d::Zero();
  int n = 0;
  for (int v = -kWindow; v <= kWindow; ++v)
    for (int u = -kWindow; u <= kWindow; ++u, ++n) {
      const Eigen::Array3d rgb = bilinear(image, at.x() + u, at.y() + v);
      sum += rgb;
      squares += rgb * rgb;
    }
  const Eigen::Array3d mean = sum / n;
  if ((squares / n - mean * mean).maxCoeff() > kRough * kRough) return std::nullopt;
  return Eigen::Vector3d(mean);
}

}  // namespace

std::vector<float> depth_map(const Mesh& mesh, const RigCamera& camera) {
  const CameraModel& m = camera.model;
  std::vector<float> depth(static_cast<std::size_t>(m.width) * m.height, kInfinity);
  std::vector<Corner> corners;
  for (const Eigen::Vector3f& p : mesh.positions) corners.push_back(see(camera, p.cast<double>()));
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const Corner &a = corners[mesh.triangles[t]], &b = corners[mesh.triangles[t + 1]],
                 &c = corners[mesh.triangles[t + 2]];
    if (!a.seen || !b.seen || !c.seen) continue;
    const double area =
        (b.pixel - a.pixel).x() * (c.pixel - a.pixel).y() - (b.pixel - a.pixel).y() * (c.pixel - a.pixel).x();
    if (std::abs(area) < 1e-12) continue;
    const Eigen::Vector2d low = a.pixel.cwiseMin(b.pixel).cwiseMin(c.pixel),
                          high = a.pixel.cwiseMax(b.pixel).cwiseMax(c.pixel);
    const int x0 = std::max(0, static_cast<int>(std::floor(low.x() - 0.5))),
              x1 = std::min(m.width - 1, static_cast<int>(std::ceil(std::min(high.x(), 1e6))));
    const int y0 = std::max(0, static_cast<int>(std::floor(low.y() - 0.5))),
              y1 = std::min(m.height - 1, static_cast<int>(std::ceil(std::min(high.y(), 1e6))));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const Eigen::Vector2d p(x + 0.5, y + 0.5);
        const auto side = [&](const Corner& s, const Corner& e) {
          return ((e.pixel - s.pixel).x() * (p - s.pixel).y() - (e.pixel - s.pixel).y() * (p - s.pixel).x()) /
                 area;
        };
        const double wa = side(b, c), wb = side(c, a), wc = side(a, b);
        if (wa < 0 || wb < 0 || wc < 0) continue;
        const auto z = static_cast<float>(1 / (wa / a.depth + wb / b.depth + wc / c.depth));
        float& there = depth[static_cast<std::size_t>(y) * m.width + x];
        there = std::min(there, z);
      }
  }
  return depth;
}

std::vector<ColorSample> surface_colors(const Mesh& mesh, const Rig& rig, const std::vector<Image>& images,
                                        int first_point, int most) {
  // Evenly over the area: each triangle gets the points whose share of it falls in its turn.
  double area = 0;
  const auto corner = [&](std::size_t i) {
    return Eigen::Vector3d(mesh.positions[mesh.triangles[i]].cast<double>());
  };
  const auto across = [&](std::size_t t) {
    return Eigen::Vector3d((corner(t + 1) - corner(t)).cross(corner(t + 2) - corner(t)));
  };
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) area += across(t).norm();
  struct Point {
    Eigen::Vector3d at, normal;
  };
  std::vector<Point> points;
  double passed = 0, next = 0;
  const double step = area / most;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size() && step > 0; t += 3) {
    const Eigen::Vector3d n = across(t);
    passed += n.norm();
    if (passed < next || n.norm() == 0) continue;
    points.push_back({(corner(t) + corner(t + 1) + corner(t + 2)) / 3, n.normalized()});
    while (next <= passed) next += step;
  }
  std::vector<ColorSample> sights;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    if (images[c].empty()) continue;
    const std::vector<float> depth = depth_map(mesh, camera);
    const Eigen::Vector3d eye = camera.cam_from_world.center();
    for (std::size_t i = 0; i < points.size(); ++i) {
      constexpr double kLeastCosine = 0.4;
      if (points[i].normal.dot((eye - points[i].at).normalized()) < kLeastCosine) continue;
      const Corner seen = see(camera, points[i].at);
      if (!seen.seen || !(seen.pixel.cwiseAbs().maxCoeff() < 1e6)) continue;
      const int x = static_cast<int>(std::floor(seen.pixel.x())),
                y = static_cast<int>(std::floor(seen.pixel.y()));
      if (!well_inside(depth, camera.model, x, y, seen.depth)) continue;
      if (const std::optional<Eigen::Vector3d> mean = smooth_mean(images[c], seen.pixel))
        sights.push_back({static_cast<int>(c), first_point + static_cast<int>(i), *mean});
    }
  }
  return sights;
}

}  // namespace floatstage::calib
