#include "core/synthetic/mesh_photograph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/random.h"

namespace floatstage {
namespace {

/// Depth (metres along z) of an ideal pinhole at every sample of a grid; infinity off the mesh.
std::vector<float> depth_grid(const Mesh& mesh, const Eigen::Matrix3d& k, const Rigid3& cam_from_world,
                              int width, int height) {
  std::vector<float> depth(static_cast<std::size_t>(width) * height, std::numeric_limits<float>::infinity());
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    Eigen::Vector3d p[3];
    Eigen::Vector2d s[3];
    bool in_front = true;
    for (int c = 0; c < 3; ++c) {
      p[c] = cam_from_world *
             Eigen::Vector3d(mesh.positions[mesh.triangles[t + static_cast<std::size_t>(c)]].cast<double>());
      in_front = in_front && p[c].z() > 1e-6;
      s[c] = (k * p[c]).hnormalized();
    }
    if (!in_front) continue;
    const double area = (s[1] - s[0]).x() * (s[2] - s[0]).y() - (s[1] - s[0]).y() * (s[2] - s[0]).x();
    if (area == 0) continue;
    const Eigen::Vector2d low = s[0].cwiseMin(s[1]).cwiseMin(s[2]), high = s[0].cwiseMax(s[1]).cwiseMax(s[2]);
    const int x0 = std::max(0, static_cast<int>(std::floor(low.x() - 0.5))),
              x1 = std::min(width - 1, static_cast<int>(std::ceil(high.x())));
    const int y0 = std::max(0, static_cast<int>(std::floor(low.y() - 0.5))),
              y1 = std::min(height - 1, static_cast<int>(std::ceil(high.y())));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const Eigen::Vector2d at(x + 0.5, y + 0.5);
        double b[3];
        for (int c = 0; c < 3; ++c) {
          const Eigen::Vector2d& u = s[(c + 1) % 3];
          const Eigen::Vector2d& v = s[(c + 2) % 3];
          b[c] = ((v - u).x() * (at - u).y() - (v - u).y() * (at - u).x()) / area;
        }
        if (b[0] < 0 || b[1] < 0 || b[2] < 0) continue;
        const double z = 1 / (b[0] / p[0].z() + b[1] / p[1].z() + b[2] / p[2].z());
        float& nearest = depth[static_cast<std::size_t>(y) * width + x];
        nearest = std::min(nearest, static_cast<float>(z));
      }
    }
  }
  return depth;
}

/// Bounds of the picture in pinhole coordinates.
Eigen::AlignedBox2d pinhole_extent(const CameraModel& model) {
  Eigen::AlignedBox2d box;
  for (int i = 0; i <= 64; ++i) {
    const double s = i / 64.0;
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(s * model.width, 0), Eigen::Vector2d(s * model.width, model.height),
          Eigen::Vector2d(0, s * model.height), Eigen::Vector2d(model.width, s * model.height)})
      if (const auto ray = unproject(model, pixel)) box.extend(Eigen::Vector2d(ray->head<2>()));
  }
  return box;
}

}  // namespace

Photograph photograph(const Mesh& mesh, const CameraModel& model, const Rigid3& cam_from_world, int samples,
                      const SolidColor& color, const Eigen::Vector3f& background) {
  // The z-buffer is a pinhole's that holds the whole picture; each sample of the picture looks up its ray
  // there.
  const Eigen::AlignedBox2d extent = pinhole_extent(model);
  const bool has_lens = !std::holds_alternative<std::monostate>(model.lens);
  const double oversampling = samples * (has_lens ? 2.0 : 1.0);
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = model.fx * oversampling;
  k(1, 1) = model.fy * oversampling;
  k(0, 1) = model.skew * oversampling;
  k(0, 2) = has_lens ? -extent.min().x() * k(0, 0) : model.cx * oversampling;
  k(1, 2) = has_lens ? -extent.min().y() * k(1, 1) : model.cy * oversampling;
  const int width =
      has_lens ? static_cast<int>(std::ceil(extent.sizes().x() * k(0, 0))) + 1 : model.width * samples;
  const int height =
      has_lens ? static_cast<int>(std::ceil(extent.sizes().y() * k(1, 1))) + 1 : model.height * samples;
  const std::vector<float> depth = depth_grid(mesh, k, cam_from_world, width, height);
  const Rigid3 world_from_cam = cam_from_world.inverse();

  Photograph out{Image(model.width, model.height, 3), Image(model.width, model.height, 1)};
  for (int y = 0; y < model.height; ++y) {
    for (int x = 0; x < model.width; ++x) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int hits = 0;
      for (int i = 0; i < samples * samples; ++i) {
        const Eigen::Vector2d pixel(x + (i % samples + 0.5) / samples, y + (i / samples + 0.5) / samples);
        const auto ray = unproject(model, pixel);
        float z = std::numeric_limits<float>::infinity();
        if (ray) {
          const Eigen::Vector2d at = (k * *ray).hnormalized();
          const int u = static_cast<int>(std::floor(at.x())), v = static_cast<int>(std::floor(at.y()));
          if (u >= 0 && v >= 0 && u < width && v < height) z = depth[static_cast<std::size_t>(v) * width + u];
        }
        if (std::isfinite(z)) {
          ++hits;
          sum += color((world_from_cam * Eigen::Vector3d(*ray * static_cast<double>(z))).cast<float>());
        } else {
          sum += background;
        }
      }
      const auto count = static_cast<float>(samples * samples);
      for (int c = 0; c < 3; ++c)
        out.rgb.at(x, y)[c] = static_cast<std::uint8_t>(std::clamp(std::lround(sum[c] / count), 0L, 255L));
      *out.alpha.at(x, y) = static_cast<std::uint8_t>(std::lround(255.F * static_cast<float>(hits) / count));
    }
  }
  return out;
}

SolidColor random_checker(float cell, std::uint64_t seed) {
  return [cell, seed](const Eigen::Vector3f& p) {
    std::uint64_t h = mix(seed);
    for (int c = 0; c < 3; ++c)
      h = mix(h ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(p[c] / cell)) + 1000003));
    return Eigen::Vector3f(static_cast<float>(h & 255), static_cast<float>(h >> 8 & 255),
                           static_cast<float>(h >> 16 & 255));
  };
}

}  // namespace floatstage
