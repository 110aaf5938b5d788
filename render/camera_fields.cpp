#include "render/camera_fields.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/content_hash.h"
#include "core/parallel.h"
#include "render/camera_block.h"
#include "render/camera_choice.h"
#include "render/depth_windows.h"
#include "render/scene_impl.h"

namespace floatstage::render {
namespace {

constexpr double kGuardPixels = 4;     // around the picture: what is read at its border has neighbours
constexpr double kLongestSide = 1024;  // px of a field: larger pictures have coarser ones

constexpr std::uint32_t kMethod = 1;  // another one's fields are not ours

/// Values one behind the other, as they lie in memory.
class Bytes {
 public:
  template <class T>
  void add(const T* values, std::size_t count) {
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
  }
  void add(std::uint32_t value) { add(&value, 1); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace

bool same_fields(const FlowOptions& a, const FlowOptions& b) {
  FlowOptions here = b;
  here.place = a.place;
  return a == here;
}

std::vector<std::int16_t> to_steps(const std::vector<float>& uv) {
  static constexpr float kFarthest = std::numeric_limits<std::int16_t>::max();
  std::vector<std::int16_t> steps(uv.size());
  std::transform(uv.begin(), uv.end(), steps.begin(), [](float v) {
    const float step = std::round(v / CameraField::kStep);
    return static_cast<std::int16_t>(std::min(std::max(step, -kFarthest), kFarthest));
  });
  return steps;
}

FieldInputs field_inputs(const Scene& scene) {
  const Scene::Impl& s = scene.impl();
  FieldInputs inputs;
  Bytes mesh;
  mesh.add(kMethod);
  mesh.add(s.mesh.positions.data(), s.mesh.positions.size());
  mesh.add(s.mesh.triangles.data(), s.mesh.triangles.size());
  inputs.mesh = content_hash(mesh.bytes());
  std::vector<std::string> hashes(s.cameras.size());
  parallel_for(s.cameras.size(), 0, [&](std::size_t i) {
    Bytes camera;
    CameraBlock block = s.blocks[i];
    block.image[2] = 0;  // its place among those in use
    camera.add(&block, 1);
    camera.add(&s.cameras[i].model.fx, 1);  // of the grid, in full
    camera.add(&s.cameras[i].model.fy, 1);
    camera.add(s.tiles[i].rgba.data(),
               4 * static_cast<std::size_t>(s.tiles[i].stride()) *
                   static_cast<std::size_t>(s.tiles[i].height + 2 * SceneTile::kApron));
    hashes[i] = content_hash(camera.bytes());
  });
  for (std::size_t i = 0; i < hashes.size(); ++i) inputs.cameras[s.rig_index[i]] = hashes[i];
  return inputs;
}

View field_view(const RigCamera& camera, const Eigen::AlignedBox3f& box) {
  const Eigen::AlignedBox2d bounds = pinhole_bounds(camera, box, kGuardPixels);
  const CameraModel& m = camera.model;
  const double across = bounds.sizes().x() * m.fx, down = bounds.sizes().y() * m.fy;
  const double scale = std::min({1.0, kLongestSide / across, kLongestSide / down});
  View view;
  view.model.fx = scale * m.fx;
  view.model.fy = scale * m.fy;
  view.model.width = std::max(2, static_cast<int>(std::ceil(scale * across)));
  view.model.height = std::max(2, static_cast<int>(std::ceil(scale * down)));
  view.model.cx = -bounds.min().x() * view.model.fx;
  view.model.cy = -bounds.min().y() * view.model.fy;
  view.view_from_world = camera.cam_from_world;
  const DepthWindow depth = depth_window(camera, box);
  view.near_plane = static_cast<double>(depth.near_plane);
  view.far_plane = static_cast<double>(depth.far_plane);
  return view;
}

std::vector<CameraPair> field_pairs(const Rig& rig, const Mesh& mesh, int neighbors,
                                    const std::vector<bool>& usable) {
  std::vector<CameraPair> pairs;
  CameraRanking ranking(rig.cameras, ranking_samples(mesh));
  const auto count = static_cast<int>(rig.cameras.size());
  for (int i = 0; i < count; ++i) {
    if (!usable.empty() && !usable[static_cast<std::size_t>(i)]) continue;
    View view;
    view.model = pinhole(rig.cameras[static_cast<std::size_t>(i)].model);
    view.view_from_world = rig.cameras[static_cast<std::size_t>(i)].cam_from_world;
    std::vector<bool> others(static_cast<std::size_t>(count));
    for (int j = 0; j < count; ++j)
      others[static_cast<std::size_t>(j)] = j != i && (usable.empty() || usable[static_cast<std::size_t>(j)]);
    const int asked = std::min(neighbors, kMostListed);
    const CameraChoice choice = choose_cameras(ranking, view, asked, others);
    for (std::size_t j = 0; j < choice.chosen; ++j) pairs.push_back({i, choice.listed[j]});
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace floatstage::render
