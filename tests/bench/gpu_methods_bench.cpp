// Pictures of the synthetic performer on a GPU while the view goes around: what each method's stages take
// there, by timer queries, and how many pictures a second come out when nothing is read back.
//
// methods/…: the mean time of a picture on the GPU's own clock. pictures_a_second/…: `fps`, as a window that
// follows the hand would see them, and `cpu_ms`, what the thread that draws needs of it.

#include <chrono>
#include <ctime>
#include <string>

#include <epoxy/gl.h>

#include "tests/bench/gpu_stages.h"
#include "tests/bench/studio.h"

namespace floatstage::render {
namespace {

constexpr int kViews = 16;  // orbit_view() has as many

double thread_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

RendererOptions with_flow_at(int shrink) {
  RendererOptions options;
  options.flow.backend = "variational";
  options.flow.shrink = shrink;
  options.flow.place = FlowPlace::Gpu;
  return options;
}

/// A renderer that has drawn every view once: storage is there, shaders are compiled, fields are made.
std::unique_ptr<ViewRenderer> warm_renderer(benchmark::State& state, const std::string& method,
                                            const RendererOptions& options, int width, int height) {
  auto renderer = std::move(*make_renderer(method, render::BackEnd::Gl));
  for (int step = 0; step < kViews; ++step)
    if (const auto drawn = renderer->render(studio().scene, orbit_view(width, height, step), options);
        !drawn) {
      state.SkipWithError(drawn.error().message.c_str());
      return nullptr;
    }
  glFinish();
  return renderer;
}

void methods(benchmark::State& state, const std::string& method, int shrink) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  if (!can_run(state, width)) return;
  const RendererOptions options = with_flow_at(shrink);
  const auto renderer = warm_renderer(state, method, options, width, height);
  if (!renderer) return;
  StageReport report;
  StageTimes times;
  int step = 0;
  for (auto _ : state) {
    if (!renderer->render(studio().scene, orbit_view(width, height, step++), options))
      return state.SkipWithError("the picture cannot be drawn");
    state.SetIterationTime(report.add(times.take()) * 1e-3);
  }
  report.write(state);
}

void pictures_a_second(benchmark::State& state, const std::string& method, int shrink) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  if (!can_run(state, width)) return;
  const RendererOptions options = with_flow_at(shrink);
  const auto renderer = warm_renderer(state, method, options, width, height);
  if (!renderer) return;
  double seconds = 0, thread = 0;
  for (auto _ : state) {
    const auto begun = std::chrono::steady_clock::now();
    const double before = thread_ms();
    for (int step = 0; step < kViews; ++step)
      if (!renderer->render(studio().scene, orbit_view(width, height, step), options))
        return state.SkipWithError("the picture cannot be drawn");
    thread += thread_ms() - before;
    glFinish();
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    state.SetIterationTime(took);
    seconds += took;
  }
  const double pictures = static_cast<double>(state.iterations()) * kViews;
  state.counters["fps"] = pictures / seconds;
  state.counters["cpu_ms"] = thread / pictures;
}

void sizes(benchmark::internal::Benchmark* bench) {
  bench->Args({256, 192})
      ->Args({512, 512})
      ->Args({1024, 768})
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

#define FLOATSTAGE_METHODS(bench)                                                \
  BENCHMARK_CAPTURE(bench, nearest, "nearest", 1)->Apply(sizes);                 \
  BENCHMARK_CAPTURE(bench, linear, "linear", 1)->Apply(sizes);                   \
  BENCHMARK_CAPTURE(bench, filtered, "filtered", 1)->Apply(sizes);               \
  BENCHMARK_CAPTURE(bench, floating_static, "floating-static", 1)->Apply(sizes); \
  BENCHMARK_CAPTURE(bench, floating, "floating", 1)->Apply(sizes);               \
  BENCHMARK_CAPTURE(bench, floating_half_flow, "floating", 2)->Apply(sizes)
FLOATSTAGE_METHODS(methods);
FLOATSTAGE_METHODS(pictures_a_second);

}  // namespace
}  // namespace floatstage::render
