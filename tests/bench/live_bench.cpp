// The live chain in one process: a synthetic take of 8 cameras 1024x768 at 25 instants a second in, 640x480
// out, for ten seconds at each quality. Prints scenes a second, latency and the mean milliseconds of every
// stage; docs/live.md has the budget that they are compared with. Run: live_bench [--benchmark_filter=live/2]

#include <cmath>

#include <benchmark/benchmark.h>

#include "pipeline/camera_path.h"
#include "pipeline/synthesize.h"
#include "render/back_end.h"
#include "studio/live/live_run.h"
#include "studio/live/take_player.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

constexpr int kWidth = 640, kHeight = 480, kInstants = 12;

struct Recorded {
  TempFolder folder;
  Recorded() {
    pipeline::SynthesizeOptions options;
    options.out = folder / "take";
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
    auto player = std::move(*TakePlayer::open(recorded.folder / "take", {.loop = true}));
    const pipeline::CameraPath path = pipeline::orbit_path(player->rig(), {}, 20);
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

BENCHMARK(live)
    ->DenseRange(0, static_cast<int>(live_qualities().size()) - 1)
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kSecond);

}  // namespace
}  // namespace floatstage::studio
