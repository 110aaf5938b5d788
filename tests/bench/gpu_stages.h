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

/// Gigabytes a second, read and written, of a copy from buffer to buffer.
inline double copy_bandwidth() {
  static const double measured = [] {
    const GLsizeiptr size = GLsizeiptr{1} << (context()->is_software() ? 20 : 28);
    const gl::Buffer from = gl::Buffer::create(), to = gl::Buffer::create();
    for (const gl::Buffer* buffer : {&from, &to}) {
      glNamedBufferStorage(buffer->id(), size, nullptr, 0);
      glClearNamedBufferData(buffer->id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, nullptr);
    }
    gl::StageTimes times;
    double best = 0;
    for (int turn = 0; turn < 5; ++turn) {
      gl::StageTimes::enter("copy");
      glCopyNamedBufferSubData(from.id(), to.id(), 0, 0, size);
      best = std::max(best, 2e-6 * static_cast<double>(size) / times.take().front().milliseconds);
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
    if (dispatches == 0) return;
    state.counters["dispatches"] = dispatches;
    state.counters["MB"] = megabytes;
    state.counters["GB/s"] = megabytes / milliseconds;
    state.counters["copy GB/s"] = copy_bandwidth();
    state.counters["share of a copy's bandwidth"] = megabytes / milliseconds / copy_bandwidth();
  }

 private:
  std::map<std::string, gl::StageTime> sums_;
  int turns_ = 0;
};

}  // namespace floatstage::render
