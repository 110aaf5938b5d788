// Every render method at 640x480, 930x720 and 1024x768 on the synthetic performer, on both back-ends; how
// they compare; and the flow alone. Run: render_bench --benchmark_filter=compare
//
// compare/…: `cpu_ms` and `gl_ms` are the process's CPU milliseconds a picture (so other work on the machine
// does not count), `ratio` is gl / cpu, `psnr_db` and `coverage` (share of pixels) how far the pictures are
// apart. `draw` is floating without flow, `picture` floating as it was (OpenGL with Dense Inverse Search)
// against native code throughout, `picture_same_flow` floating with the variational flow on both.

#include <chrono>
#include <cmath>
#include <ctime>
#include <map>
#include <string>

#include <benchmark/benchmark.h>

#include "tests/bench/studio.h"

namespace floatstage::render {
namespace {

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

double wall_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void draw(benchmark::State& state, const std::string& method, render::BackEnd back_end,
          Alignment alignment = Alignment::Flow) {
  const Studio& on = studio();  // first: it makes the context current
  auto renderer = std::move(*make_renderer(method, back_end));
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  RendererOptions options;
  options.alignment = alignment;
  int step = 0;
  for (auto _ : state) {
    const auto picture = renderer->render(on.scene, orbit_view(width, height, step++), options);
    if (!picture) return state.SkipWithError(picture.error().message.c_str());
    benchmark::DoNotOptimize(download(*picture));
  }
  state.SetItemsProcessed(state.iterations());
}

/// Squared differences and coverage of pictures of the same views.
struct Apart {
  double squares = 0, both = 0, one = 0, all = 0;
  void add(const Image& a, const Image& b) {
    for (std::size_t i = 0; i < a.pixels.size(); i += 4) {
      ++all;
      const bool in_a = a.pixels[i + 3] != 0, in_b = b.pixels[i + 3] != 0;
      one += in_a != in_b;
      if (!in_a || !in_b) continue;
      ++both;
      for (std::size_t c = 0; c < 3; ++c) squares += std::pow(a.pixels[i + c] - b.pixels[i + c], 2);
    }
  }
  double psnr() const { return 10 * std::log10(255.0 * 255 / std::max(squares / (3 * both), 1e-9)); }
};

/// A new scene every time, as films of moving subjects and live pictures have it: depth maps are drawn too.
void compare(benchmark::State& state, const FlowOptions& gl_flow, const FlowOptions& cpu_flow,
             bool same_scene) {
  Studio& on = studio();
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  constexpr int kPictures = 4;
  std::map<render::BackEnd, double> ms;
  for (auto _ : state) {
    std::map<render::BackEnd, std::vector<Image>> pictures;
    for (const render::BackEnd back_end : {render::BackEnd::Gl, render::BackEnd::Cpu}) {
      auto renderer = std::move(*make_renderer("floating", back_end));
      RendererOptions options;
      options.flow = back_end == render::BackEnd::Gl ? gl_flow : cpu_flow;
      for (int i = -1; i < kPictures; ++i) {
        if (!same_scene)
          if (!on.scene.set(on.rig, on.frame)) return state.SkipWithError("the scene cannot be set");
        const double begun = cpu_ms();
        const auto picture = renderer->render(on.scene, orbit_view(width, height, std::max(i, 0)), options);
        if (!picture) return state.SkipWithError(picture.error().message.c_str());
        Image copy = download(*picture);
        if (i < 0) continue;  // storage grows, shaders are compiled
        ms[back_end] += (cpu_ms() - begun) / kPictures;
        pictures[back_end].push_back(std::move(copy));
      }
    }
    Apart apart;
    for (std::size_t i = 0; i < kPictures; ++i)
      apart.add(pictures[render::BackEnd::Gl][i], pictures[render::BackEnd::Cpu][i]);
    state.counters["psnr_db"] = apart.psnr();
    state.counters["coverage"] = apart.one / apart.all;
  }
  const auto n = static_cast<double>(state.iterations());
  state.counters["gl_ms"] = ms[render::BackEnd::Gl] / n;
  state.counters["cpu_ms"] = ms[render::BackEnd::Cpu] / n;
  state.counters["ratio"] = ms[render::BackEnd::Gl] / ms[render::BackEnd::Cpu];
  state.SetLabel(context()->description());
}

/// What soft outlines cost: pictures with and without them in turns, a new scene every time.
void outlines(benchmark::State& state, const std::string& method) {
  Studio& on = studio();
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  auto renderer = std::move(*make_renderer(method, render::BackEnd::Cpu));
  std::map<bool, double> best;
  for (auto _ : state)
    for (int round = 0; round < 8; ++round)
      for (const bool soft : {false, true}) {
        RendererOptions options;
        options.soft_outlines = soft;
        if (!on.scene.set(on.rig, on.frame)) return state.SkipWithError("the scene cannot be set");
        const double begun = cpu_ms();
        if (!renderer->render(on.scene, orbit_view(width, height, round), options))
          return state.SkipWithError("no picture");
        const double took = cpu_ms() - begun;
        if (round > 0) best[soft] = best[soft] == 0 ? took : std::min(best[soft], took);
      }
  state.counters["hard_ms"] = best[false];
  state.counters["soft_ms"] = best[true];
  state.counters["ratio"] = best[true] / best[false];
}

/// Wall time of the draw on one thread and on two.
void two_threads(benchmark::State& state) {
  Studio& on = studio();
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  RendererOptions options;
  options.flow.backend = "none";
  auto renderer = std::move(*make_renderer("floating", render::BackEnd::Cpu));
  std::map<int, double> best;
  for (auto _ : state)
    for (int round = 0; round < 12; ++round)
      for (const int threads : {1, 2}) {
        options.threads = threads;
        if (!on.scene.set(on.rig, on.frame)) return state.SkipWithError("the scene cannot be set");
        const double begun = wall_ms();
        if (!renderer->render(on.scene, orbit_view(width, height, round), options))
          return state.SkipWithError("no picture");
        const double took = wall_ms() - begun;
        if (round > 0) best[threads] = best[threads] == 0 ? took : std::min(best[threads], took);
      }
  state.counters["one_ms"] = best[1];
  state.counters["two_ms"] = best[2];
  state.counters["ratio"] = best[1] / best[2];
}

void set_scene(benchmark::State& state) {
  Studio& s = studio();
  for (auto _ : state)
    if (!s.scene.set(s.rig, s.frame)) state.SkipWithError("the scene cannot be set");
}

FlowOptions flow_of(const char* backend) {
  FlowOptions options;
  options.backend = backend;
  return options;
}

void flow(benchmark::State& state, const std::string& preset, int finest_scale) {
  FlowOptions options = flow_of("dis");
  options.preset = preset;
  options.finest_scale = finest_scale;
  auto estimator = std::move(*make_flow_estimator(options));
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  std::vector<std::uint8_t> a, b;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      a.push_back(static_cast<std::uint8_t>(128 + 60 * std::sin(0.31 * x) * std::cos(0.23 * y) +
                                            60 * std::sin(0.11 * x + 0.17 * y)));
      b.push_back(static_cast<std::uint8_t>(128 + 60 * std::sin(0.31 * (x - 3)) * std::cos(0.23 * y) +
                                            60 * std::sin(0.11 * (x - 3) + 0.17 * y)));
    }
  for (auto _ : state)
    benchmark::DoNotOptimize(estimate_flow(*estimator, {width, height, a.data()}, {width, height, b.data()}));
}

/// Milliseconds of the processor a picture with fields that are there already, and times those of linear.
void at_rest(benchmark::State& state, render::BackEnd back_end) {
  const Studio& on = studio();
  constexpr int kViews = 4;
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  std::map<std::string, double> ms;
  for (auto _ : state)
    for (const char* method : {"linear", "floating-static"}) {
      auto renderer = std::move(*make_renderer(method, back_end));
      double begin = 0;
      for (int step = 0; step < 2 * kViews; ++step) {  // first all that is made once
        if (step == kViews) begin = cpu_ms();
        const auto picture = renderer->render(on.scene, orbit_view(width, height, step % kViews), {});
        if (!picture) return state.SkipWithError(picture.error().message.c_str());
        benchmark::DoNotOptimize(download(*picture));
      }
      ms[method] += (cpu_ms() - begin) / kViews;
    }
  const auto count = static_cast<double>(state.iterations());
  state.counters["linear_ms"] = ms["linear"] / count;
  state.counters["static_ms"] = ms["floating-static"] / count;
  state.counters["ratio"] = ms["floating-static"] / ms["linear"];
}

void sizes(benchmark::internal::Benchmark* bench) {
  bench->Args({640, 480})->Args({930, 720})->Args({1024, 768})->Unit(benchmark::kMillisecond)->UseRealTime();
}

constexpr render::BackEnd kCpu = render::BackEnd::Cpu, kGl = render::BackEnd::Gl;
const FlowOptions kNoFlow = flow_of("none"), kDis = flow_of("dis"), kNative = flow_of("variational");
BENCHMARK_CAPTURE(compare, draw, kNoFlow, kNoFlow, false)->Apply(sizes)->Iterations(2);
BENCHMARK_CAPTURE(compare, draw_same_scene, kNoFlow, kNoFlow, true)->Apply(sizes)->Iterations(2);
BENCHMARK_CAPTURE(compare, picture, kDis, kNative, false)->Apply(sizes)->Iterations(1);
BENCHMARK_CAPTURE(compare, picture_same_flow, kNative, kNative, false)->Apply(sizes)->Iterations(1);
BENCHMARK_CAPTURE(outlines, linear, std::string("linear"))->Apply(sizes)->Iterations(1);
BENCHMARK_CAPTURE(outlines, floating, std::string("floating"))->Apply(sizes)->Iterations(1);
BENCHMARK(two_threads)->Apply(sizes)->Iterations(1);
BENCHMARK_CAPTURE(draw, nearest_cpu, std::string("nearest"), kCpu)->Apply(sizes);
BENCHMARK_CAPTURE(draw, linear_cpu, std::string("linear"), kCpu)->Apply(sizes);
BENCHMARK_CAPTURE(draw, floating_cpu, std::string("floating"), kCpu)->Apply(sizes);
BENCHMARK_CAPTURE(draw, floating_depth_cpu, std::string("floating"), kCpu, Alignment::Depth)->Apply(sizes);
BENCHMARK_CAPTURE(at_rest, cpu, kCpu)->Apply(sizes)->Iterations(2);
BENCHMARK_CAPTURE(at_rest, gl, kGl)->Apply(sizes)->Iterations(1);
BENCHMARK_CAPTURE(draw, nearest_gl, std::string("nearest"), kGl)->Apply(sizes);
BENCHMARK_CAPTURE(draw, linear_gl, std::string("linear"), kGl)->Apply(sizes);
BENCHMARK_CAPTURE(draw, floating_gl, std::string("floating"), kGl)->Apply(sizes);
BENCHMARK(set_scene)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, dis_medium_full, std::string("medium"), 0)->Apply(sizes);
BENCHMARK_CAPTURE(flow, dis_medium_half, std::string("medium"), 1)->Apply(sizes);
BENCHMARK_CAPTURE(flow, dis_fast_full, std::string("fast"), 0)->Apply(sizes);

}  // namespace
}  // namespace floatstage::render
