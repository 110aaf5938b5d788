// What a picture costs before its first pixel: its cameras, its window and the levels of its photographs, for
// the synthetic performer (8 cameras) and for a large mesh (150,000 triangles, 48 cameras). `reference` is
// the slow way that the others are tested against. Run: view_bench

#include <cmath>
#include <stdexcept>

#include <benchmark/benchmark.h>

#include "core/synthetic/synthetic_studio.h"
#include "render/footprint.h"
#include "render/renderer_checks.h"
#include "render/scene_impl.h"
#include "render/view_window.h"

namespace floatstage::render {
namespace {

/// A body without symmetry, in strips as surface meshes come.
Mesh large_mesh() {
  constexpr int kRings = 194, kAround = 388;
  Mesh mesh;
  for (int r = 0; r <= kRings; ++r)
    for (int a = 0; a < kAround; ++a) {
      const double theta = M_PI * r / kRings, phi = 2 * M_PI * a / kAround;
      const double radius = 0.5 + 0.1 * std::sin(3 * phi + 5 * theta) + 0.02 * std::sin(40 * phi) * theta;
      mesh.positions.emplace_back(
          (radius * Eigen::Vector3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                                    2 * std::cos(theta)) +
           Eigen::Vector3d(0, 0, 1))
              .cast<float>());
    }
  for (int r = 0; r < kRings; ++r)
    for (int a = 0; a < kAround; ++a) {
      const auto at = [&](int row, int column) {
        return static_cast<std::uint32_t>(row * kAround + column % kAround);
      };
      const std::uint32_t nw = at(r, a), ne = at(r, a + 1), sw = at(r + 1, a), se = at(r + 1, a + 1);
      mesh.triangles.insert(mesh.triangles.end(), {nw, sw, ne, ne, sw, se});
    }
  return mesh;
}

struct Subject {
  Rig rig;
  Mesh mesh;
  Scene scene;

  explicit Subject(bool large) {
    rig = synthetic_rig({.cameras = large ? 48 : 8, .width = 64, .height = 48});
    mesh = large ? large_mesh() : SyntheticStudio::create(rig, {})->performer(0);
    SceneFrame frame;
    frame.mesh = mesh;
    for (const RigCamera& camera : rig.cameras)
      frame.images.frames.push_back(make_frame({}, Image(camera.model.width, camera.model.height, 3)));
    if (const Result<void> ok = scene.set(rig, frame); !ok) throw std::runtime_error(ok.error().message);
  }
};

const Subject& subject(bool large) {
  static const Subject performer(false), crowd(true);
  return large ? crowd : performer;
}

/// Between the first two cameras, and a little farther on each call, as an orbit does.
View orbit_view(const Rig& rig, int step) {
  const RigCamera& camera = rig.cameras.front();
  View view;
  view.model = camera.model;
  const Eigen::Vector3d target = focus_point(rig), eye = camera.cam_from_world.center();
  const Eigen::AngleAxisd turn(0.3 + 0.01 * step, Eigen::Vector3d::UnitZ());
  view.view_from_world = look_at(target + turn * (eye - target), target, Eigen::Vector3d::UnitZ());
  return view;
}

template <class Work>
void for_views(benchmark::State& state, bool large, Work work) {
  const Subject& on = subject(large);
  std::vector<View> views;
  for (int step = 0; step < 16; ++step) views.push_back(orbit_view(on.rig, step));
  std::size_t turn = 0;
  for (auto _ : state) benchmark::DoNotOptimize(work(on.scene.impl(), views[turn++ % views.size()]));
}

void choose(benchmark::State& state, bool large) {
  for_views(state, large, [](const Scene::Impl& s, const View& view) { return s.choose(view, 3); });
}

void choose_reference(benchmark::State& state, bool large) {
  const RankingSamples samples = ranking_samples(subject(large).mesh);
  for_views(state, large,
            [&](const Scene::Impl& s, const View& view) { return mean_angles(s.cameras, samples, view); });
}

void window_reference(benchmark::State& state, bool large) {
  for_views(state, large,
            [](const Scene::Impl& s, const View& view) { return window_of(view, s.mesh.positions, 8); });
}

void window(benchmark::State& state, bool large) {
  for_views(state, large, [](const Scene::Impl& s, const View& view) {
    return window_of(view, s.mesh.positions, s.vertex_blocks, 8);
  });
}

void levels(benchmark::State& state, bool large) {
  for_views(state, large, [](const Scene::Impl& s, const View& view) {
    int deepest = 0;
    for (std::size_t i = 0; i < 8; ++i) deepest += deepest_level(s.cameras[i], view, s.box);
    return deepest;
  });
}

void checks(benchmark::State& state) {
  const Scene& scene = subject(false).scene;
  const View view = orbit_view(subject(false).rig, 0);
  for (auto _ : state) benchmark::DoNotOptimize(check_render(scene, view, {}));
}

/// What a scene costs, its photographs (64 x 48) aside.
void set_scene(benchmark::State& state, bool large) {
  const Subject& on = subject(large);
  Scene scene;
  const Image picture(on.rig.cameras[0].model.width, on.rig.cameras[0].model.height, 3),
      matte(picture.width, picture.height, 1);
  const std::vector<PictureTile> tiles{{.camera = 0, .picture = &picture, .matte = &matte}};
  for (auto _ : state)
    if (!scene.set(on.rig, on.mesh, tiles)) return state.SkipWithError("the scene cannot be set");
}

BENCHMARK_CAPTURE(choose, performer, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(choose, large, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(choose_reference, performer, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(choose_reference, large, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(window, performer, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(window, large, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(window_reference, performer, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(window_reference, large, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(levels, performer, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(levels, large, true)->Unit(benchmark::kMicrosecond);
BENCHMARK(checks)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(set_scene, performer, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(set_scene, large, true)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace floatstage::render
