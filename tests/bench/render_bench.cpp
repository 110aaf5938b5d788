// Every render method at 640x480 and 1024x768 on the synthetic performer, and the flow alone.
// Run: render_bench --benchmark_filter=Render/

#include <cmath>
#include <memory>
#include <string>

#include <benchmark/benchmark.h>

#include "core/synthetic/synthetic_studio.h"
#include "render/gl_context.h"
#include "render/renderer.h"

namespace floatstage::render {
namespace {

/// One instant of the studio on the GPU, shared by all benches of the program.
struct Stage {
  std::unique_ptr<GlContext> context;
  Rig rig;
  SceneFrame scene;
  SceneTextures textures;

  Stage() {
    context = std::move(*GlContext::headless());
    rig = synthetic_rig({});
    const SyntheticStudio studio = std::move(*SyntheticStudio::create(rig, {}));
    for (int i = 0; i < static_cast<int>(rig.cameras.size()); ++i) {
      SyntheticShot shot = studio.shoot(i, 0);
      scene.images.frames.push_back(std::move(shot.frame));
      scene.mattes.push_back(std::move(shot.matte));
    }
    scene.mesh = studio.performer(0);
    if (const Result<void> ok = textures.upload(rig, scene); !ok)
      throw std::runtime_error(ok.error().message);
  }
};

Stage& stage() {
  static Stage shared;
  return shared;
}

/// Between the first two cameras, and a little farther on each call, as an orbit does.
View orbit_view(int width, int height, int step) {
  const RigCamera& camera = stage().rig.cameras.front();
  View view;
  view.model = camera.model;
  const double scale = static_cast<double>(width) / camera.model.width;
  view.model.width = width;
  view.model.height = height;
  for (double* v : {&view.model.fx, &view.model.fy, &view.model.cx, &view.model.cy}) *v *= scale;
  const Eigen::Vector3d target = focus_point(stage().rig), eye = camera.cam_from_world.center();
  const Eigen::AngleAxisd turn(0.3 + 0.01 * (step % 16), Eigen::Vector3d::UnitZ());
  view.view_from_world = look_at(target + turn * (eye - target), target, Eigen::Vector3d::UnitZ());
  return view;
}

void render(benchmark::State& state, const std::string& method) {
  const Stage& on = stage();  // first: it makes the context current
  auto renderer = std::move(*make_renderer(method));
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  int step = 0;
  for (auto _ : state) {
    const auto picture = renderer->render(on.textures, orbit_view(width, height, step++), {});
    if (!picture) return state.SkipWithError(picture.error().message.c_str());
    benchmark::DoNotOptimize(download(*picture));
  }
  state.SetItemsProcessed(state.iterations());
  state.SetLabel(on.context->description());
}

void upload(benchmark::State& state) {
  Stage& s = stage();
  for (auto _ : state)
    if (!s.textures.upload(s.rig, s.scene)) state.SkipWithError("upload failed");
}

void flow(benchmark::State& state, const std::string& preset, int finest_scale) {
  FlowOptions options;
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
    benchmark::DoNotOptimize(estimator->estimate({width, height, a.data()}, {width, height, b.data()}));
}

void sizes(benchmark::internal::Benchmark* bench) {
  bench->Args({640, 480})->Args({1024, 768})->Unit(benchmark::kMillisecond)->UseRealTime();
}

BENCHMARK_CAPTURE(render, nearest, std::string("nearest"))->Apply(sizes);
BENCHMARK_CAPTURE(render, linear, std::string("linear"))->Apply(sizes);
BENCHMARK_CAPTURE(render, floating, std::string("floating"))->Apply(sizes);
BENCHMARK(upload)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, dis_medium_full, std::string("medium"), 0)->Apply(sizes);
BENCHMARK_CAPTURE(flow, dis_medium_half, std::string("medium"), 1)->Apply(sizes);
BENCHMARK_CAPTURE(flow, dis_fast_full, std::string("fast"), 0)->Apply(sizes);

}  // namespace
}  // namespace floatstage::render
