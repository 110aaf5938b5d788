#include <algorithm>
#include <cmath>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/frame.h"
#include "core/graph_cut.h"
#include "core/grid_cut.h"
#include "core/random.h"
#include "matting/keyers/backing_field.h"
#include "matting/keyers/clean_up.h"
#include "matting/keyers/live_key.h"

// Milliseconds a frame on one core, clean-up included. A person-sized ellipse stands before a backing with
// uneven light.
namespace floatstage::matting {
namespace {

enum class Around { Cloth, Black, ClothAndWall };

Image stage(int width, int height, Around around, bool person) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = 2.0 * x / width - 1, v = 2.0 * y / height - 1, light = 1 - 0.4 * (u * u + v * v) / 2;
      std::uint8_t* p = image.at(x, y);
      const bool subject = person && u * u / 0.04 + v * v / 0.6 < 1;
      const bool lamp = std::fmod(u + 1, 0.3) < 0.03 && std::fmod(v + 1, 0.4) < 0.04;
      double rgb[3] = {40 * light, 120 * light, 60 * light};
      if (around == Around::Black) std::fill_n(rgb, 3, 3.0);
      if (around == Around::ClothAndWall && v < 0)
        std::fill_n(rgb, 3, lamp ? 150.0 : 12 + 2 * std::sin(x * 0.7));
      if (subject) rgb[0] = 180, rgb[1] = 90 + 60 * std::sin(x * 0.5), rgb[2] = 70;
      for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>(rgb[c]);
    }
  }
  return image;
}

void key_a_frame(benchmark::State& state, const std::string& spec, Around around, int width, int height) {
  const auto keyer = make_keyer(spec, {stage(width, height, around, false)});
  const Frame frame = make_frame({}, stage(width, height, around, true));
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

// Two ways to the same in turns: `ratio` is how many times faster the second is, in CPU time.
template <class Slow, class Fast>
void in_turns(benchmark::State& state, const Slow& slow, const Fast& fast) {
  double reference = 0, other = 0;
  for (auto _ : state) {
    const std::clock_t begun = std::clock();
    benchmark::DoNotOptimize(slow());
    const std::clock_t between = std::clock();
    benchmark::DoNotOptimize(fast());
    reference += static_cast<double>(between - begun);
    other += static_cast<double>(std::clock() - between);
  }
  const double ms = 1e3 / CLOCKS_PER_SEC / static_cast<double>(state.iterations());
  state.counters["slow_ms"] = reference * ms;
  state.counters["fast_ms"] = other * ms;
  state.counters["ratio"] = reference / other;
}

// BackingField::key() beside no more of it than its distances, pixel by pixel.
void field_key(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  const auto field = learn_field({stage(width, height, Around::Black, false)}, {}, {.darker_too = true});
  const Image picture = stage(width, height, Around::Black, true);
  const auto distances = [&] {
    return std::pair(field->distances(picture, BackingField::Scale::Pixel),
                     field->distances(picture, BackingField::Scale::Cell));
  };
  in_turns(state, distances, [&] { return field->key(picture); });
}
BENCHMARK(field_key)->Args({640, 480})->Args({1024, 768})->Unit(benchmark::kMillisecond);

// clean_up() beside itself by labels.
void clean_a_key(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  const Image picture = stage(width, height, Around::Black, true);
  Image key(width, height, 1);
  for (std::size_t i = 0; i < key.pixels.size(); ++i)
    key.pixels[i] = picture.pixels[3 * i] > 9 || i % 977 == 0 ? 255 : 0;
  const CleanupOptions options{.thin_radius = 3, .smallest_island = 0.03};
  in_turns(
      state, [&] { return clean_up_by_labels(key, options); }, [&] { return clean_up(key, options); });
}
BENCHMARK(clean_a_key)->Args({640, 480})->Args({1024, 768})->Unit(benchmark::kMillisecond);

// A cut of pixels beside the same one of a graph that is written down.
void cut_a_grid(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  Random random(3);
  const std::vector<std::uint8_t> members = [&] {
    std::vector<std::uint8_t> all(static_cast<std::size_t>(width + 2) * static_cast<std::size_t>(height + 2),
                                  0);
    for (int y = 1; y <= height; ++y) std::fill_n(all.begin() + y * (width + 2) + 1, width, std::uint8_t{1});
    return all;
  }();
  std::vector<std::int32_t> odds(members.size(), 0);
  for (int y = 1; y <= height; ++y)
    for (int x = 1; x <= width; ++x)
      odds[static_cast<std::size_t>(y * (width + 2) + x)] = static_cast<std::int32_t>(
          (std::hypot(x - width / 2, y - height / 2) < height / 3.0 ? 3000 : -3000) + 4000 * random.normal());
  constexpr std::int32_t kPrice = 1500;
  const int offsets[] = {1, -1, width + 2, -width - 2, width + 3, -width - 3, width + 1, -width - 1};
  const auto graph = [&] {
    GraphCut cut(static_cast<int>(members.size()), 4 * members.size());
    for (int p = 0; p < static_cast<int>(members.size()); ++p) {
      if (!members[static_cast<std::size_t>(p)]) continue;
      cut.add_terminals(p, std::max(odds[static_cast<std::size_t>(p)], 0),
                        std::max(-odds[static_cast<std::size_t>(p)], 0));
      for (int d = 0; d < 8; d += 2)
        if (members[static_cast<std::size_t>(p + offsets[d])])
          cut.add_edge(p, p + offsets[d], kPrice, kPrice);
    }
    return cut.solve();
  };
  const auto grid = [&] {
    GridCut cut(width, height, members);
    for (int p = 0; p < static_cast<int>(members.size()); ++p) {
      if (!members[static_cast<std::size_t>(p)]) continue;
      GridCut::Room prices;
      for (std::size_t d = 0; d < 8; ++d)
        prices[d] = kPrice * members[static_cast<std::size_t>(p + offsets[d])];
      cut.set(p, odds[static_cast<std::size_t>(p)], prices);
    }
    return cut.solve();
  };
  in_turns(state, graph, grid);
}
BENCHMARK(cut_a_grid)->Args({320, 240})->Args({640, 480})->Unit(benchmark::kMillisecond);

// LiveKey beside key().
void live_key(benchmark::State& state, const std::string& spec) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  const auto keyer = make_keyer(spec, {stage(width, height, Around::Cloth, false)});
  const Frame frame = make_frame({}, stage(width, height, Around::Cloth, true));
  LiveKey live(**keyer);
  in_turns(
      state, [&] { return (*keyer)->key(frame); }, [&] { return live.key(frame); });
}
void live_sizes(benchmark::internal::Benchmark* bench) {
  bench->Args({640, 480})->Args({1024, 768})->Unit(benchmark::kMillisecond);
}
BENCHMARK_CAPTURE(live_key, chroma, "chroma")->Apply(live_sizes);
BENCHMARK_CAPTURE(live_key, difference, "difference")->Apply(live_sizes);
BENCHMARK_CAPTURE(live_key, plate, "plate")->Apply(live_sizes);

void add(const std::string& name, const std::string& spec, Around around) {
  for (const auto& [width, height] : {std::pair{640, 480}, std::pair{1024, 768}, std::pair{1920, 1080}})
    benchmark::RegisterBenchmark(
        (name + "/" + std::to_string(width) + "x" + std::to_string(height)).c_str(),
        [=, w = width, h = height](benchmark::State& state) { key_a_frame(state, spec, around, w, h); })
        ->Unit(benchmark::kMillisecond);
}

int register_all() {
  for (const KeyerInfo& keyer : keyers())
    add(keyer.name, keyer.name, keyer.name == "luminance" ? Around::Black : Around::Cloth);
  add("chroma_and_walls", "chroma", Around::ClothAndWall);
  return 0;
}

const int registered = register_all();

}  // namespace
}  // namespace floatstage::matting
