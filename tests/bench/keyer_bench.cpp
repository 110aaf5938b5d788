#include <cmath>
#include <ctime>
#include <string>

#include <benchmark/benchmark.h>

#include "core/frame.h"
#include "matting/keyers/keyer.h"
#include "matting/keyers/live_key.h"

// Milliseconds a frame on one core, clean-up included. A person-sized ellipse stands before a backing with
// uneven light.
namespace floatstage::matting {
namespace {

Image stage(int width, int height, bool black, bool person) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = 2.0 * x / width - 1, v = 2.0 * y / height - 1, light = 1 - 0.4 * (u * u + v * v) / 2;
      std::uint8_t* p = image.at(x, y);
      const bool subject = person && u * u / 0.04 + v * v / 0.6 < 1;
      const double rgb[3] = {subject ? 180 : 40 * light, subject ? 90 + 60 * std::sin(x * 0.5) : 120 * light,
                             subject ? 70 : 60 * light};
      for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>(black && !subject ? 3 : rgb[c]);
    }
  }
  return image;
}

void key_a_frame(benchmark::State& state, const std::string& spec, int width, int height) {
  const bool black = spec == "luminance";
  const auto keyer = make_keyer(spec, {stage(width, height, black, false)});
  const Frame frame = make_frame({}, stage(width, height, black, true));
  double covered = 0;
  for (auto _ : state) {
    auto matte = (*keyer)->key(frame);
    benchmark::DoNotOptimize(matte);
    covered = coverage(*matte);
  }
  state.counters["coverage"] = covered;
  state.counters["Mpx/s"] = benchmark::Counter(static_cast<double>(width) * height * 1e-6,
                                               benchmark::Counter::kIsIterationInvariantRate);
}

// LiveKey beside key(), in turns: `ratio` is how many times faster it is, in CPU time.
void live_key(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  const auto keyer = make_keyer("chroma", {stage(width, height, false, false)});
  const Frame frame = make_frame({}, stage(width, height, false, true));
  LiveKey live(**keyer);
  double reference = 0, fast = 0;
  for (auto _ : state) {
    const std::clock_t begun = std::clock();
    benchmark::DoNotOptimize((*keyer)->key(frame));
    const std::clock_t keyed = std::clock();
    benchmark::DoNotOptimize(live.key(frame));
    reference += static_cast<double>(keyed - begun);
    fast += static_cast<double>(std::clock() - keyed);
  }
  const double ms = 1e3 / CLOCKS_PER_SEC / static_cast<double>(state.iterations());
  state.counters["key_ms"] = reference * ms;
  state.counters["live_ms"] = fast * ms;
  state.counters["ratio"] = reference / fast;
}
BENCHMARK(live_key)->Args({640, 480})->Args({1024, 768})->Unit(benchmark::kMillisecond);

int register_all() {
  for (const KeyerInfo& keyer : keyers())
    for (const auto& [width, height] : {std::pair{640, 480}, std::pair{1024, 768}})
      benchmark::RegisterBenchmark(
          (keyer.name + "/" + std::to_string(width) + "x" + std::to_string(height)).c_str(),
          [name = keyer.name, w = width, h = height](benchmark::State& state) {
            key_a_frame(state, name, w, h);
          })
          ->Unit(benchmark::kMillisecond);
  return 0;
}

const int registered = register_all();

}  // namespace
}  // namespace floatstage::matting
