// The solver on what an operator records: eight cameras with 200 board views each. Goal: 10 s on two cores.

#include <benchmark/benchmark.h>

#include "calib/calibrate.h"
#include "tests/calib/synthetic_capture.h"

namespace floatstage::calib {
namespace {

void solve_eight_cameras(benchmark::State& state) {
  const CaptureOptions options{.frames = 400, .extent = 0.9, .frame_seconds = 0.2};
  Observations seen = capture(ring_rig(8), two_sided_board(8, 6, 0.12, 0.006), wandering(options), options);
  // As many views as the goal names, of every camera.
  constexpr int kViews = 200;
  std::vector<int> views(8);
  std::erase_if(seen.views,
                [&](const TargetView& v) { return ++views[static_cast<std::size_t>(v.camera)] > kViews; });
  for (auto _ : state) {
    const Result<Calibration> solved = calibrate(seen, {.threads = static_cast<int>(state.range(0))});
    if (!solved) return state.SkipWithError("it was not solved");
    benchmark::DoNotOptimize(solved->rig);
  }
  state.counters["views"] = static_cast<double>(seen.views.size());
}
BENCHMARK(solve_eight_cameras)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1);

}  // namespace
}  // namespace floatstage::calib
