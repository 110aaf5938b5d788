#include <benchmark/benchmark.h>

#include "core/synthetic/performer.h"
#include "core/synthetic/stage_scene.h"
#include "core/synthetic/synthetic_studio.h"

// CPU milliseconds on one core: what one more frame costs (a scene, shared by all cameras), and one more
// camera (a shot).
namespace floatstage {
namespace {

void pose_the_performer(benchmark::State& state) {
  const synthetic::Performer performer(1);
  double t = 0;
  for (auto _ : state) benchmark::DoNotOptimize(performer.positions(t += 0.04));
  state.counters["triangles"] = static_cast<double>(performer.triangles().size()) / 3;
}
BENCHMARK(pose_the_performer)->Unit(benchmark::kMillisecond);

void build_and_light_a_scene(benchmark::State& state) {
  const synthetic::Performer performer(1);
  const synthetic::Device device(rtcNewDevice("threads=1,set_affinity=0"));
  double t = 0;
  for (auto _ : state) benchmark::DoNotOptimize(synthetic::StageScene(device.get(), performer, t += 0.04));
}
BENCHMARK(build_and_light_a_scene)->Unit(benchmark::kMillisecond);

void shoot(benchmark::State& state) {
  const Rig rig = synthetic_rig(
      {.cameras = 1, .width = static_cast<int>(state.range(0)), .height = static_cast<int>(state.range(1))});
  const auto studio = SyntheticStudio::create(
      rig, {.samples = static_cast<int>(state.range(2)), .defects = {.noise = 2, .lens_k1 = -0.1}});
  benchmark::DoNotOptimize(studio->shoot(0, 0));  // the scene is built here and kept
  for (auto _ : state) benchmark::DoNotOptimize(studio->shoot(0, 0));
}
BENCHMARK(shoot)
    ->ArgNames({"w", "h", "samples"})
    ->Args({640, 480, 4})
    ->Args({640, 480, 9})
    ->Args({640, 480, 16})
    ->Args({1024, 768, 9})
    ->Unit(benchmark::kMillisecond);

void set_up_a_studio(benchmark::State& state) {
  const Rig rig = synthetic_rig({.cameras = static_cast<int>(state.range(0))});
  for (auto _ : state) benchmark::DoNotOptimize(SyntheticStudio::create(rig, {.samples = 9}));
}
BENCHMARK(set_up_a_studio)
    ->ArgName("cameras")
    ->Arg(1)
    ->Arg(8)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace floatstage
