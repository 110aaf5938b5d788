// The live chain in one process: a synthetic take of 8 cameras 1024x768 at 25 instants a second in, 640x480
// out, for ten seconds at each quality. Prints scenes a second, latency and the mean milliseconds of every
// stage; docs/live.md has the budget that they are compared with. Run: live_bench [--benchmark_filter=live/2]
// LIVE_BENCH_TAKE: a take of one's own in its place. `instant` does the work of one instant on one thread,
// stage after stage, in CPU milliseconds: what a machine that is shared can still tell.

#include <cmath>
#include <ctime>

#include <benchmark/benchmark.h>

#include "core/text.h"
#include "pipeline/orbit.h"
#include "pipeline/synthesize.h"
#include "render/back_end.h"
#include "studio/live/live_run.h"
#include "studio/live/live_view.h"
#include "studio/live/take_player.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

constexpr int kWidth = 640, kHeight = 480, kInstants = 12;

struct Recorded {
  TempFolder folder;
  std::filesystem::path take = folder / "take";
  Recorded() {
    if (const char* given = std::getenv("LIVE_BENCH_TAKE")) {
      take = given;
      return;
    }
    pipeline::SynthesizeOptions options;
    options.out = take;
    options.rig.width = 1024;
    options.rig.height = 768;
    options.studio.samples = 4;
    options.frames = kInstants;
    options.take.codec = capture::TakeCodec::Raw;
    if (const Result<void> ok = pipeline::synthesize_take(options); !ok)
      throw std::runtime_error(ok.error().message);
  }
};

void live(benchmark::State& state) {
  static const Recorded recorded;
  const auto drawing = std::move(*render::open_back_end(render::BackEnd::Auto));
  LiveRunOptions options;
  options.renderer.back_end = drawing.back_end;
  options.width = kWidth;
  options.height = kHeight;
  options.quality = static_cast<std::size_t>(state.range(0));
  options.target_fps = 0;
  options.seconds = 10;
  for (auto _ : state) {
    auto player = std::move(*TakePlayer::open(recorded.take, {.loop = true}));
    const pipeline::CameraPath path = pipeline::orbit_around(player->rig(), {}, {.seconds = 20}).path;
    const Result<LiveReport> report = run_live(
        *player, {}, options,
        [&](double s) {
          return pipeline::view_of(pipeline::sample(path, std::fmod(s, 20)), kWidth, kHeight, {});
        },
        [] { return false; }, {});
    if (!report) return state.SkipWithError(report.error().message.c_str());
    state.counters["fps"] = report->shown.mean(report->seconds);
    state.counters["latency_p50_ms"] = report->latency.percentile(0.5);
    state.counters["latency_p99_ms"] = report->latency.percentile(0.99);
    for (const auto& [name, series] : report->stages) state.counters[name + "_ms"] = series.mean();
  }
  state.SetLabel(describe(live_qualities()[options.quality]));
}

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

TimedSet set_of(capture::TakeReader& take, int instant) {
  TimedSet set;
  set.instant.epoch = static_cast<std::uint64_t>(instant);
  set.images = std::move(*take.frame_set(instant));
  set.produced.resize(set.images.frames.size());
  return set;
}

void instant(benchmark::State& state) {
  static const Recorded recorded;
  const LiveQuality& quality = live_qualities()[static_cast<std::size_t>(state.range(0))];
  auto player = std::move(*TakePlayer::open(recorded.take, {}));
  const Rig& rig = player->rig();
  CameraRack rack = std::move(*CameraRack::make(rig, "chroma", player->samples()));
  Reconstruction reconstruction(rig, "");
  LiveView drawn(rig);
  Reused<LiveScene> scenes;
  render::RendererOptions options;
  options.alignment = render::Alignment::Auto;  // as `live` has it
  options.back_end = render::BackEnd::Cpu;
  options.threads = 1;
  const pipeline::CameraPath path = pipeline::orbit_around(rig, {}, {.seconds = 20}).path;
  std::vector<TimedSet> sets;
  for (int i = 0; i < kInstants; ++i) sets.push_back(set_of(player->take(), i));
  double stages[4] = {}, triangles = 0, points = 0;
  int count = -kInstants;  // a round to grow the memory
  std::vector<bool> textured;
  for (auto _ : state) {
    if (count == 0) std::fill(std::begin(stages), std::end(stages), triangles = points = 0);
    const View view = pipeline::view_of(pipeline::sample(path, std::fmod(0.1 * (count + kInstants), 20)),
                                        kWidth, kHeight, {});
    const std::shared_ptr<LiveScene> scene = scenes.take();
    scene->times = {};
    const double begun = cpu_ms();
    rack.look(sets[static_cast<std::size_t>((count + kInstants) % kInstants)], textured, quality.node, 1,
              scene->times, scene->views);
    const double looked = cpu_ms();
    benchmark::DoNotOptimize(reconstruction.make(scene->views, 1, scene->scene));
    const double carved = cpu_ms();
    benchmark::DoNotOptimize(drawn.show(scene));
    const double shown = cpu_ms();
    benchmark::DoNotOptimize(drawn.render(view, quality, options));
    const double done = cpu_ms();
    textured.assign(rig.cameras.size(), false);
    for (const int camera : render::needed_cameras(rig, scene->scene.mesh, view, options.cameras))
      textured[static_cast<std::size_t>(camera)] = true;
    const double spent[4] = {looked - begun, carved - looked, shown - carved, done - shown};
    for (int i = 0; i < 4; ++i) stages[i] += spent[i];
    triangles += static_cast<double>(scene->scene.mesh.triangles.size()) / 3;
    for (const auto& seen : scene->views) points += static_cast<double>(seen->outline.points.size());
    ++count;
  }
  const char* const names[4] = {"nodes", "hull", "upload", "render"};
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += stages[i] / count;
  for (int i = 0; i < 4; ++i) state.counters[text(names[i], "_cpu_ms")] = stages[i] / count;
  state.counters["sum_cpu_ms"] = sum;
  state.counters["triangles"] = triangles / count;
  state.counters["points"] = points / count;
  state.SetLabel(describe(quality));
}

// What outlines cost the hull, and what that does to pictures: cameras drawn from the others' photographs.
struct LeftOut {
  double squared = 0, covered = 0, pixels = 0;

  void add(const CameraView& seen, const Image& drawn) {
    const ForegroundTile& tile = *seen.tile;
    for (int y = 0; y < tile.picture.height; ++y)
      for (int x = 0; x < tile.picture.width; ++x) {
        if (*tile.matte.at(x, y) < 250) continue;
        const std::uint8_t *p = tile.picture.at(x, y), *q = drawn.at(tile.x + x, tile.y + y);
        ++pixels;
        if (q[3] < 128) continue;
        ++covered;
        for (int c = 0; c < 3; ++c) squared += (p[c] - q[c]) * (p[c] - q[c]) / 3.0;
      }
  }
  double psnr() const { return 10 * std::log10(255 * 255 * covered / squared); }
};

void outlines(benchmark::State& state) {
  static const Recorded recorded;
  NodeQuality quality;
  quality.smallest = 1e-6 * static_cast<double>(state.range(0));
  quality.tolerance = 0.01 * static_cast<double>(state.range(1));
  auto player = std::move(*TakePlayer::open(recorded.take, {}));
  const Rig& rig = player->rig();
  CameraRack rack = std::move(*CameraRack::make(rig, "chroma", player->samples()));
  Reconstruction reconstruction(rig, "");
  LeftOut all;
  double hull = 0, triangles = 0, points = 0;
  for (auto _ : state) {
    LiveScene scene;
    rack.look(set_of(player->take(), 5), {}, quality, 1, scene.times, scene.views);
    for (int round = 0; round < 4; ++round) {  // the first grows the memory
      const double begun = cpu_ms();
      benchmark::DoNotOptimize(reconstruction.make(scene.views, 1, scene.scene));
      if (round > 0) hull += (cpu_ms() - begun) / 3;
    }
    triangles = static_cast<double>(scene.scene.mesh.triangles.size()) / 3;
    for (const auto& seen : scene.views) points += static_cast<double>(seen->outline.points.size());
    for (std::size_t left_out = 0; left_out < rig.cameras.size(); left_out += 2) {
      LiveScene others = scene;
      others.views[left_out] = nullptr;
      render::Scene drawn;
      std::vector<render::PictureTile> tiles;
      if (!*set_scene(others, rig, tiles, drawn)) return state.SkipWithError("nothing to draw");
      const RigCamera& camera = rig.cameras[left_out];
      render::MethodRenderers renderers;
      const auto picture =
          *renderers.render("floating", drawn, {camera.model, camera.cam_from_world, 0.01, 100}, {});
      all.add(*scene.views[left_out], render::download(picture));
    }
  }
  state.counters["hull_cpu_ms"] = hull;
  state.counters["triangles"] = triangles;
  state.counters["points"] = points;
  state.counters["psnr_dB"] = all.psnr();
  state.counters["covered"] = all.covered / all.pixels;
}

BENCHMARK(outlines)
    ->ArgNames({"smallest_1e-6", "tolerance_px_100"})
    ->Args({0, 50})
    ->ArgsProduct({{20, 40, 80}, {50, 75, 100}})
    ->Iterations(1);
BENCHMARK(instant)
    ->DenseRange(0, static_cast<int>(live_qualities().size()) - 1)
    ->Iterations(3 * kInstants)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(live)
    ->DenseRange(0, static_cast<int>(live_qualities().size()) - 1)
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kSecond);

}  // namespace
}  // namespace floatstage::studio
