// Octree hulls of a torus seen by ring cameras at 640x480: what a frame of the demo costs, and where the time
// goes.
//   hull_bench --benchmark_filter=VisualHull

#include <benchmark/benchmark.h>

#include "recon/mesh/mesh_check.h"
#include "recon/mesh/mesh_cleanup.h"
#include "recon/octree/octree_carve.h"
#include "recon/octree/octree_surface.h"
#include "recon/visual_hull.h"
#include "tests/support/analytic_shapes.h"

namespace floatstage::recon {
namespace {

struct Scene {
  explicit Scene(int cameras)
      : rig(shapes::ring_rig({.cameras = cameras, .distance = 3, .width = 640, .height = 480, .focal = 600})),
        mattes(shapes::render_mattes(rig, shapes::torus({0, 0, 0}, 0.6, 0.2))) {
    for (std::size_t i = 0; i < mattes.size(); ++i) views.emplace_back(rig.cameras[i], mattes[i]);
  }
  Rig rig;
  std::vector<Matte> mattes;
  std::vector<OctreeView> views;
  Eigen::AlignedBox3d box{Eigen::Vector3d(-0.85, -0.85, -0.3), Eigen::Vector3d(0.85, 0.85, 0.3)};
};

void VisualHull(benchmark::State& state) {
  const Scene scene(static_cast<int>(state.range(0)));
  HullOptions options;
  options.method = HullMethod::Octree;
  options.resolution = static_cast<int>(state.range(1));
  options.threads = static_cast<int>(state.range(2));
  for (auto _ : state) {
    const Result<HullReport> hull = visual_hull(scene.rig, scene.mattes, options);
    if (!hull) return state.SkipWithError(hull.error().message.c_str());
    state.counters["triangles"] = static_cast<double>(hull->mesh.triangle_count());
  }
}
BENCHMARK(VisualHull)
    ->ArgNames({"cameras", "resolution", "threads"})
    ->Args({8, 160, 1})
    ->Args({8, 160, 2})
    ->Args({8, 256, 1})
    ->Args({20, 256, 1})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

void PrepareView(benchmark::State& state) {
  const Scene scene(1);
  for (auto _ : state) benchmark::DoNotOptimize(OctreeView(scene.rig.cameras[0], scene.mattes[0]));
}
BENCHMARK(PrepareView)->Unit(benchmark::kMillisecond);

void Carve(benchmark::State& state) {
  const Scene scene(8);
  for (auto _ : state)
    benchmark::DoNotOptimize(carve(scene.views, scene.box, static_cast<int>(state.range(0)), 1));
}
BENCHMARK(Carve)->Arg(160)->Arg(256)->Unit(benchmark::kMillisecond);

void ExtractSurface(benchmark::State& state) {
  const Scene scene(8);
  const CarvedGrid grid = carve(scene.views, scene.box, static_cast<int>(state.range(0)), 1);
  for (auto _ : state) benchmark::DoNotOptimize(extract_surface(grid, scene.views, 1));
}
BENCHMARK(ExtractSurface)->Arg(160)->Arg(256)->Unit(benchmark::kMillisecond);

void CleanupFor(benchmark::State& state) {
  const Scene scene(8);
  const CarvedGrid grid = carve(scene.views, scene.box, static_cast<int>(state.range(0)), 1);
  const Surface surface = extract_surface(grid, scene.views, 1);
  for (auto _ : state)
    benchmark::DoNotOptimize(clean_up(surface, {.voxel = grid.voxel(), .largest_move = 0.5, .threads = 1}));
}
BENCHMARK(CleanupFor)->Arg(160)->Arg(256)->Unit(benchmark::kMillisecond);

void CheckMesh(benchmark::State& state) {
  const Scene scene(8);
  HullOptions options;
  options.method = HullMethod::Octree;
  options.resolution = static_cast<int>(state.range(0));
  const Result<HullReport> hull = visual_hull(scene.rig, scene.mattes, options);
  for (auto _ : state) benchmark::DoNotOptimize(check_mesh(hull->mesh));
}
BENCHMARK(CheckMesh)->Arg(160)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace floatstage::recon
