// The flow in compute kernels, by timer queries: GPU milliseconds, dispatches
// and megabytes of every stage (those that are moved if nothing is read twice and the proxy covers
// everything), and the share of the bandwidth that a copy has on the same GPU; of whole pictures
// gpu_methods_bench.cpp. Where OpenGL is software only the smallest size runs.

#include <benchmark/benchmark.h>

#include "tests/bench/gpu_stages.h"
#include "tests/render/flow/gpu_flow.h"
#include "tests/render/flow/pictures.h"

namespace floatstage::render {
namespace {

FlowOptions flow_on_gpu(int finest) {
  FlowOptions options;
  options.backend = "variational";
  options.finest_scale = finest;
  options.place = FlowPlace::Gpu;
  return options;
}

/// Six fields between three pictures that are already on the GPU; a disc of them is the proxy, or everything.
void six_fields(benchmark::State& state, int finest, FlowPrecision precision, bool masked) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  if (!can_run(state, width)) return;
  const std::vector<std::uint8_t> pictures[] = {test::grainy(width, height, 0, 0),
                                                test::grainy(width, height, 3, -2),
                                                test::grainy(width, height, -4, 1)};
  const std::vector<std::uint8_t> round = test::disc(width, height);
  std::vector<FlowImage> images;
  for (const auto& picture : pictures)
    images.push_back({width, height, picture.data(), masked ? round.data() : nullptr});
  const FlowPair pairs[] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};
  const gl::Texture uploaded = test::upload_pictures(images);
  FlowTables tables;
  tables.write(test::wanted_fields(pairs));
  FlowCompute solver = std::move(*FlowCompute::create(precision));
  const VariationalPreset preset = *variational_preset(flow_on_gpu(finest));
  StageReport report;
  solver.solve(preset, tables, uploaded, width, height);
  glFinish();
  StageTimes times;
  for (auto _ : state) {
    solver.solve(preset, tables, uploaded, width, height);
    state.SetIterationTime(report.add(times.take()) * 1e-3);
  }
  report.write(state);
  const double pixels = 6.0 * width * height;
  state.counters["bytes a pixel and field"] = state.counters["MB"] * 1e6 / pixels;
}

void sizes(benchmark::internal::Benchmark* bench) {
  bench->Args({256, 192})->Args({1024, 768})->UseManualTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(six_fields, gpu_half_floats, 0, FlowPrecision::Half, false)->Apply(sizes);
BENCHMARK_CAPTURE(six_fields, gpu_half_floats_disc, 0, FlowPrecision::Half, true)->Apply(sizes);
BENCHMARK_CAPTURE(six_fields, gpu_half_floats_half_size, 1, FlowPrecision::Half, false)->Apply(sizes);
BENCHMARK_CAPTURE(six_fields, gpu_floats, 0, FlowPrecision::Float, false)->Apply(sizes);

}  // namespace
}  // namespace floatstage::render
