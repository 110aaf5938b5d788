#pragma once

// What benches of render/gl share: whether there is a GPU to time, the bandwidth of a copy on it, and the
// sums of the timer queries of a picture's stages.

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "render/gl/flow_levels.h"
#include "render/gl/stage_times.h"
#include "tests/bench/bench_context.h"

namespace floatstage::render {

inline constexpr int kLargestOnSoftware = 256;  // px of width

/// Gigabytes a second, read and written, of a copy from texture to texture.
inline double copy_bandwidth() {
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

}  // namespace floatstage::render
