#include "render/cpu/scene_maps.h"

#include <algorithm>

#include "core/parallel.h"
#include "render/closed_mesh.h"

namespace floatstage::render::cpu {
namespace {

/// The camera of a depth map: ideal pinhole coordinates on the window's grid.
RasterCamera depth_camera(const RigCamera& camera, const DepthWindow& window) {
  const Eigen::Matrix<double, 3, 4> m = camera.cam_from_world.matrix().topRows<3>();
  RasterCamera out;
  auto place = [&](std::size_t i) { return static_cast<double>(window.place[i]); };
  out.rows.row(0) = (place(0) * m.row(0) + place(2) * m.row(2)).cast<float>();
  out.rows.row(1) = (place(1) * m.row(1) + place(3) * m.row(2)).cast<float>();
  out.rows.row(2) = m.row(2).cast<float>();
  out.near_plane = window.near_plane;
  out.far_plane = window.far_plane;
  out.width = window.width;
  out.height = window.height;
  return out;
}

std::size_t texels(const DepthWindow& window) {
  return static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
}

}  // namespace

SceneMaps& SceneMaps::of(const Scene::Impl& scene) {
  if (!scene.on_cpu) scene.on_cpu = std::make_shared<SceneMaps>();
  SceneMaps& maps = *static_cast<SceneMaps*>(scene.on_cpu.get());
  if (maps.version != scene.version) {
    maps.version = scene.version;
    maps.closed = is_closed(scene.mesh);
    if (maps.maps.size() < scene.cameras.size()) maps.maps.resize(scene.cameras.size());
    for (Map& map : maps.maps) map.drawn = false;
  }
  return maps;
}

void ProxyRaster::run(const Scene::Impl& scene, const RasterCamera& view, std::span<const int> wanted,
                      int threads, float* inverse_z, std::uint32_t* triangle) {
  SceneMaps& maps = SceneMaps::of(scene);
  std::size_t count = 0;
  auto add = [&](const RasterCamera& camera, float* depth, std::uint32_t* ids) {
    if (targets_.size() <= count) targets_.resize(count + 1);
    Target& target = targets_[count++];
    target.mesh.begin(scene.mesh, camera, maps.closed);
    target.height = camera.height;
    target.inverse_z = depth;
    target.triangle = ids;
  };
  add(view, inverse_z, triangle);
  for (int camera : wanted) {
    const auto i = static_cast<std::size_t>(camera);
    SceneMaps::Map& map = maps.maps[i];
    if (map.drawn) continue;
    map.drawn = true;
    if (map.inverse_z.size() < texels(scene.depth_windows[i]))
      map.inverse_z.resize(texels(scene.depth_windows[i]));
    add(depth_camera(scene.cameras[i], scene.depth_windows[i]), map.inverse_z.data(), nullptr);
  }
  const std::size_t chunks = targets_[0].mesh.chunks();
  parallel_for(count * chunks, threads,
               [&](std::size_t i) { targets_[i / chunks].mesh.project(i % chunks); });
  // Bands only so that threads have equal work: each band walks over all triangles.
  const auto workers = static_cast<std::size_t>(threads > 0 ? threads : default_threads());
  const std::size_t bands = workers == 1 ? 1 : std::max<std::size_t>(1, (4 * workers + count - 1) / count);
  parallel_for(count * bands, threads, [&](std::size_t i) {
    const Target& target = targets_[i / bands];
    const auto row = [&](std::size_t band) {
      return static_cast<int>(band * static_cast<std::size_t>(target.height) / bands);
    };
    target.mesh.draw(row(i % bands), row(i % bands + 1), target.inverse_z, target.triangle);
  });
}

}  // namespace floatstage::render::cpu
