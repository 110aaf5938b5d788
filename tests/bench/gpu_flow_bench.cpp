// The flow in compute kernels, and the whole floating picture, by timer queries: GPU milliseconds, dispatches
// and megabytes of every stage (those that are moved if nothing is read twice and the proxy covers
// everything), and the share of the bandwidth that a copy has on the same GPU. Where OpenGL is software only
// the smallest size runs.

#include <algorithm>
#include <map>

#include <benchmark/benchmark.h>

#include "core/text.h"
#include "render/gl/stage_times.h"
#include "render/gl_context.h"
#include "tests/render/flow/gpu_flow.h"
#include "tests/render/flow/pictures.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

constexpr int kLargestOnSoftware = 256;  // px of width

const GlContext* context() {
  static const Result<std::unique_ptr<GlContext>> made = GlContext::headless();
  return made ? made->get() : nullptr;
}

/// Gigabytes a second, read and written, of a copy from texture to texture.
double copy_bandwidth() {
  static const double measured = [] {
    const int side = context()->is_software() ? 256 : 4096;
    gl::Texture from, to;
    reserve_cleared(from, GL_RGBA32F, side, side, 2);
    reserve_cleared(to, GL_RGBA32F, side, side, 2);
    gl::StageTimes times;
    double best = 0;
    for (int turn = 0; turn < 5; ++turn) {
      gl::StageTimes::enter("copy");
      glCopyImageSubData(from.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, to.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0,
                         side, side, 2);
      const double bytes = 2.0 * 2 * 16 * side * side;
      best = std::max(best, bytes * 1e-6 / times.take().front().milliseconds);
    }
    return best;
  }();
  return measured;
}

/// False, with the reason in `state`, where a picture of this width cannot be timed.
bool can_run(benchmark::State& state, int width) {
  if (context() == nullptr) return state.SkipWithError("no OpenGL 4.5 here"), false;
  if (context()->is_software() && width > kLargestOnSoftware)
    return state.SkipWithError("OpenGL is software here: nothing to be learnt at this size"), false;
  copy_bandwidth();  // measured before anything else is timed
  state.SetLabel(context()->description());
  return true;
}

/// Sums stages over a run and reports their means.
class StageReport {
 public:
  double add(const std::vector<gl::StageTime>& stages) {
    double total = 0;
    for (const gl::StageTime& stage : stages) {
      gl::StageTime& sum = sums_[stage.name];
      sum.milliseconds += stage.milliseconds;
      sum.dispatches = stage.dispatches;
      sum.least_megabytes = stage.least_megabytes;
      total += stage.milliseconds;
    }
    ++turns_;
    return total;
  }
  void write(benchmark::State& state) const {
    double milliseconds = 0, megabytes = 0;
    int dispatches = 0;
    for (const auto& [name, sum] : sums_) {
      state.counters[name + " ms"] = sum.milliseconds / turns_;
      state.counters[name + " dispatches"] = sum.dispatches;
      state.counters[name + " MB"] = sum.least_megabytes;
      if (sum.dispatches == 0) continue;
      milliseconds += sum.milliseconds / turns_;
      megabytes += sum.least_megabytes;
      dispatches += sum.dispatches;
    }
    state.counters["dispatches"] = dispatches;
    state.counters["MB"] = megabytes;
    state.counters["GB/s"] = megabytes / milliseconds;
    state.counters["share of a copy's bandwidth"] = megabytes / milliseconds / copy_bandwidth();
  }

 private:
  std::map<std::string, gl::StageTime> sums_;
  int turns_ = 0;
};

FlowOptions flow_on_gpu(int finest, int shrink = 1) {
  FlowOptions options;
  options.backend = "variational";
  options.finest_scale = finest;
  options.shrink = shrink;
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
  gl::StageTimes times;
  for (auto _ : state) {
    solver.solve(preset, tables, uploaded, width, height);
    state.SetIterationTime(report.add(times.take()) * 1e-3);
  }
  report.write(state);
  const double pixels = 6.0 * width * height;
  state.counters["bytes a pixel and field"] = state.counters["MB"] * 1e6 / pixels;
}

/// A ball that five cameras photographed, drawn with its flow.
void floating_picture(benchmark::State& state, int shrink) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  if (!can_run(state, width)) return;
  const Stage stage = photographed(arc(5, 25, small_camera(512, 384)), ball(0.25F, 96), ball(0.26F, 48));
  render::Scene scene;
  if (!scene.set(stage.rig, stage.scene)) return state.SkipWithError("the scene cannot be set");
  const auto renderer = std::move(*make_renderer("floating", render::BackEnd::Gl));
  RendererOptions options;
  options.flow = flow_on_gpu(0, shrink);
  const View view = view_at(8, 20, small_camera(width, height));
  if (!renderer->render(scene, view, options)) return state.SkipWithError("the picture cannot be drawn");
  glFinish();
  StageReport report;
  gl::StageTimes times;
  for (auto _ : state) {
    if (!renderer->render(scene, view, options)) return state.SkipWithError("the picture cannot be drawn");
    state.SetIterationTime(report.add(times.take()) * 1e-3);
  }
  report.write(state);
}

void sizes(benchmark::internal::Benchmark* bench) {
  bench->Args({256, 192})->Args({1024, 768})->UseManualTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(six_fields, gpu_half_floats, 0, FlowPrecision::Half, false)->Apply(sizes);
BENCHMARK_CAPTURE(six_fields, gpu_half_floats_disc, 0, FlowPrecision::Half, true)->Apply(sizes);
BENCHMARK_CAPTURE(six_fields, gpu_half_floats_half_size, 1, FlowPrecision::Half, false)->Apply(sizes);
BENCHMARK_CAPTURE(six_fields, gpu_floats, 0, FlowPrecision::Float, false)->Apply(sizes);
BENCHMARK_CAPTURE(floating_picture, gpu, 1)->Apply(sizes);
BENCHMARK_CAPTURE(floating_picture, gpu_flow_half_size, 2)->Apply(sizes);

}  // namespace
}  // namespace floatstage::render
