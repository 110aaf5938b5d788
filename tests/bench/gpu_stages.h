#pragma once

// What benches of render/gl share: whether there is a GPU to time, the bandwidth of a copy on it, and the
// sums of the timer queries of a picture's stages.

#include <algorithm>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "render/gl/flow_levels.h"
#include "render/stage_times.h"
#include "tests/bench/bench_context.h"

namespace floatstage::render {

inline constexpr int kLargestOnSoftware = 256;  // px of width

/// Gigabytes a second, read and written, of a kernel that does nothing else (fade.comp).
inline double copy_bandwidth() {
  static const double measured = [] {
    const int side = context()->is_software() ? 256 : 4096;
    gl::Texture now, sum, shown;
    reserve_cleared(now, GL_RGBA32F, side, side, 0);
    reserve_cleared(sum, GL_RGBA32F, side, side, 0);
    reserve_cleared(shown, GL_RGBA8, side, side, 0);
    gl::Kernel fade = std::move(*gl::Kernel::create("fade.comp", {}));
    StageTimes times;
    double best = 0;
    for (int turn = 0; turn < 5; ++turn) {
      StageTimes::enter("copy");
      fade.over(side, side, {&now, nullptr}, {&sum, &shown});
      const StageTime took = times.take().front();
      best = std::max(best, took.least_megabytes / took.milliseconds);
    }
    return best;
  }();
  return measured;
}

/// False, with the reason in `state`, where a picture of this width cannot be timed.
inline bool can_run(benchmark::State& state, int width) {
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
  /// What one picture took; the sum of it, ms.
  double add(const std::vector<StageTime>& stages) {
    double total = 0;
    for (const StageTime& stage : stages) total += stage.milliseconds;
    render::add(stages, sums_);
    ++turns_;
    return total;
  }
  void write(benchmark::State& state) const {
    double milliseconds = 0, megabytes = 0, dispatches = 0;
    for (const StageTime& sum : sums_) {
      state.counters[sum.name + " ms"] = sum.milliseconds / turns_;
      state.counters[sum.name + " dispatches"] = static_cast<double>(sum.dispatches) / turns_;
      state.counters[sum.name + " MB"] = sum.least_megabytes / turns_;
      if (sum.dispatches == 0) continue;
      milliseconds += sum.milliseconds / turns_;
      megabytes += sum.least_megabytes / turns_;
      dispatches += static_cast<double>(sum.dispatches) / turns_;
    }
    if (dispatches == 0) return;
    state.counters["dispatches"] = dispatches;
    state.counters["MB"] = megabytes;
    state.counters["GB/s"] = megabytes / milliseconds;
    state.counters["copy GB/s"] = copy_bandwidth();
    state.counters["share of a copy's bandwidth"] = megabytes / milliseconds / copy_bandwidth();
  }

 private:
  std::vector<StageTime> sums_;
  int turns_ = 0;
};

}  // namespace floatstage::render
