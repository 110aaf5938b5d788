#include "pipeline/export/surface_sights.h"

#include <algorithm>
#include <cmath>

#include "calib/surface_colors.h"
#include "core/parallel.h"
#include "pipeline/bicubic.h"

namespace floatstage::pipeline {
namespace {

constexpr double kToleranceShare = 0.0125;  // of the mesh's diagonal, as the renderers have it
constexpr std::size_t kBlended = 3;         // photographs, as the renderers' --blend
constexpr std::uint8_t kOpaque = 128;

// A photograph that shows a vertex, and how many of its pixels fall on a square metre there.
struct Shown {
  std::size_t camera;
  Eigen::Vector2d pixel;
  double density;
};

std::vector<Shown> photographs_of(const StraightInstant& instant, const SurfaceSights& sights,
                                  const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  std::vector<Shown> shown;
  for (std::size_t c = 0; c < instant.rig.cameras.size(); ++c) {
    const RigCamera& camera = instant.rig.cameras[c];
    const Eigen::Vector3d to_camera = camera.cam_from_world.center() - point;
    const double cosine = normal.dot(to_camera.normalized());
    if (!(cosine > 0)) continue;
    const std::optional<Eigen::Vector2d> pixel = sights.see(c, point);
    if (!pixel) continue;
    shown.push_back({c, *pixel, cosine * camera.model.fx * camera.model.fy / to_camera.squaredNorm()});
  }
  std::stable_sort(shown.begin(), shown.end(),
                   [](const Shown& a, const Shown& b) { return a.density > b.density; });
  return shown;
}

std::optional<Eigen::Vector3d> blended(const StraightInstant& instant, const std::vector<Shown>& shown) {
  const double last = shown.size() > kBlended ? shown[kBlended].density : 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0;
  for (std::size_t i = 0; i < std::min(shown.size(), kBlended); ++i) {
    const double weight = shown[i].density - last + 1e-9 * shown[i].density;  // four alike: a plain mean
    for (int k = 0; k < 3; ++k)
      sum[k] +=
          weight * read_bicubic(instant.pictures[shown[i].camera], shown[i].pixel.x(), shown[i].pixel.y(), k);
    total += weight;
  }
  if (total <= 0) return std::nullopt;
  return sum / total;
}

// Colours spread along edges, a ring of vertices a round, until all have one.
void spread(const Mesh& mesh, std::vector<std::optional<Eigen::Vector3d>>& colors) {
  for (bool any = true; any;) {
    any = false;
    std::vector<Eigen::Vector4d> sums(colors.size(), Eigen::Vector4d::Zero());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::uint32_t from = mesh.triangles[t], to = mesh.triangles[t % 3 == 2 ? t - 2 : t + 1];
      for (const auto& [a, b] : {std::pair{from, to}, std::pair{to, from}})
        if (colors[a] && !colors[b]) sums[b] += colors[a]->homogeneous();
    }
    for (std::size_t v = 0; v < colors.size(); ++v) {
      if (colors[v] || sums[v].w() == 0) continue;
      colors[v] = sums[v].hnormalized();
      any = true;
    }
  }
}

Rgb to_rgb8(const Eigen::Vector3d& color) {
  Rgb rgb;
  for (int k = 0; k < 3; ++k)
    rgb[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(std::clamp(std::lround(color[k]), 0L, 255L));
  return rgb;
}

}  // namespace

SurfaceSights::SurfaceSights(const StraightInstant& instant)
    : instant_(instant), depth_(instant.rig.cameras.size()) {
  if (!instant.mesh.positions.empty())
    tolerance_ = kToleranceShare * static_cast<double>(bounding_box(instant.mesh).diagonal().norm());
  parallel_for(depth_.size(), 0,
               [&](std::size_t i) { depth_[i] = calib::depth_map(instant.mesh, instant.rig.cameras[i]); });
}

bool SurfaceSights::is_nearest(std::size_t camera, const Eigen::Vector2d& pixel, double z) const {
  const CameraModel& m = instant_.rig.cameras[camera].model;
  const int x0 = static_cast<int>(std::floor(pixel.x() - 0.5)),
            y0 = static_cast<int>(std::floor(pixel.y() - 0.5));
  const double fx = pixel.x() - 0.5 - x0, fy = pixel.y() - 0.5 - y0;
  double behind = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const int x = std::clamp(x0 + i, 0, m.width - 1), y = std::clamp(y0 + j, 0, m.height - 1);
      if (depth_[camera][static_cast<std::size_t>(y) * m.width + x] >= z - tolerance_)
        behind += (i == 1 ? fx : 1 - fx) * (j == 1 ? fy : 1 - fy);
    }
  return behind >= 0.5;
}

std::optional<Eigen::Vector2d> SurfaceSights::see(std::size_t camera, const Eigen::Vector3d& point) const {
  const RigCamera& c = instant_.rig.cameras[camera];
  const Eigen::Vector3d p = c.cam_from_world * point;
  const std::optional<Eigen::Vector2d> pixel = project(c.model, p);
  if (!pixel || !inside(c.model, *pixel)) return std::nullopt;
  if (const Image& matte = instant_.mattes[camera]; !matte.empty())
    if (*matte.at(static_cast<int>(pixel->x()), static_cast<int>(pixel->y())) < kOpaque) return std::nullopt;
  if (!is_nearest(camera, *pixel, p.z())) return std::nullopt;
  return pixel;
}

std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.positions.size(), Eigen::Vector3f::Zero());
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const std::uint32_t a = mesh.triangles[t], b = mesh.triangles[t + 1], c = mesh.triangles[t + 2];
    const Eigen::Vector3f n =
        (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
    for (const std::uint32_t v : {a, b, c}) normals[v] += n;
  }
  for (Eigen::Vector3f& n : normals) n.normalize();  // zero stays zero
  return normals;
}

std::vector<Rgb> colors_of_vertices(const StraightInstant& instant, const SurfaceSights& sights,
                                    const Mesh& mesh) {
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  std::vector<std::optional<Eigen::Vector3d>> colors(mesh.positions.size());
  constexpr std::size_t kBlock = 1024;
  parallel_for((colors.size() + kBlock - 1) / kBlock, 0, [&](std::size_t block) {
    for (std::size_t v = block * kBlock; v < std::min(colors.size(), (block + 1) * kBlock); ++v)
      colors[v] = blended(instant, photographs_of(instant, sights, mesh.positions[v].cast<double>(),
                                                  normals[v].cast<double>()));
  });
  spread(mesh, colors);
  std::vector<Rgb> out;
  out.reserve(colors.size());
  for (const std::optional<Eigen::Vector3d>& color : colors)
    out.push_back(to_rgb8(color.value_or(Eigen::Vector3d::Zero())));
  return out;
}

}  // namespace floatstage::pipeline
