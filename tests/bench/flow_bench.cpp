// Optical flow on Middlebury's pairs, every back-end and preset: end-point error (epe, px), angular error
// (aae, degrees) and milliseconds of the processor a pair. And six fields of three pictures, as `floating`
// asks for. Run: flow_bench

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include <benchmark/benchmark.h>

#include "core/png.h"
#include "render/flow.h"
#include "render/flow/flo_file.h"
#include "render/flow/flow_kernels.h"
#include "render/flow/flow_score.h"
#include "tests/support/places.h"

namespace floatstage::render {
namespace {

const char* const kPairs[] = {"RubberWhale", "Grove2", "Dimetrodon", "Venus"};

struct Pair {
  int width = 0, height = 0;
  std::vector<std::uint8_t> first, second;
  FlowField truth;
};

/// Null when the data is not there.
const Pair* load(const std::string& name) {
  static std::map<std::string, Pair> loaded;
  const auto found = loaded.find(name);
  if (found != loaded.end()) return &found->second;
  const std::filesystem::path folder = data_folder() / "flow" / name;
  const Result<Image> a = load_png(folder / "frame10.png"), b = load_png(folder / "frame11.png");
  Result<FlowField> truth = load_flo(folder / "flow10.flo");
  if (!a || !b || !truth) return nullptr;
  return &(loaded[name] = {a->width, a->height, flow_gray(*a), flow_gray(*b), std::move(*truth)});
}

FlowOptions options_of(const std::string& backend, const std::string& preset, int finest) {
  FlowOptions options;
  options.backend = backend;
  options.preset = preset;
  options.finest_scale = finest;
  return options;
}

void pairs(benchmark::State& state, const std::string& backend, const std::string& preset, int finest) {
  const std::string name = kPairs[state.range(0)];
  const Pair* pair = load(name);
  if (pair == nullptr) return state.SkipWithError("the data is not on this machine");
  const auto estimator = std::move(*make_flow_estimator(options_of(backend, preset, finest)));
  Result<FlowField> field = FlowField{};
  for (auto _ : state)
    field = estimate_flow(*estimator, {pair->width, pair->height, pair->first.data()},
                          {pair->width, pair->height, pair->second.data()});
  const Result<FlowScore> score = score_flow(*field, pair->truth);
  if (!score) return state.SkipWithError(score.error().message.c_str());
  state.counters["epe"] = score->epe;
  state.counters["aae"] = score->aae;
  state.SetLabel(name + (backend == "variational" ? ", " + native_flow_kernels().name : ""));
}

/// Three pictures of a pair, its second one shifted once more, and their six fields.
void six_fields(benchmark::State& state, const std::string& backend, const std::string& preset, int finest) {
  const Pair* pair = load("RubberWhale");
  if (pair == nullptr) return state.SkipWithError("the data is not on this machine");
  const auto estimator = std::move(*make_flow_estimator(options_of(backend, preset, finest)));
  std::vector<std::uint8_t> third = pair->second;
  std::rotate(third.begin(), third.begin() + 2, third.end());
  const FlowImage images[] = {{pair->width, pair->height, pair->first.data()},
                              {pair->width, pair->height, pair->second.data()},
                              {pair->width, pair->height, third.data()}};
  const FlowPair asked[] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};
  std::vector<FlowField> fields(6);
  for (auto _ : state)
    if (!estimator->estimate(images, asked, {}, 1, fields)) state.SkipWithError("failed");
}

void each(benchmark::internal::Benchmark* bench) { bench->DenseRange(0, 3)->Unit(benchmark::kMillisecond); }

BENCHMARK_CAPTURE(pairs, dis_medium, "dis", "medium", 0)->Apply(each);
BENCHMARK_CAPTURE(pairs, variational_quality, "variational", "quality", 0)->Apply(each);
BENCHMARK_CAPTURE(pairs, variational_fast, "variational", "fast", 0)->Apply(each);
BENCHMARK_CAPTURE(pairs, variational_fast_half, "variational", "fast", 1)->Apply(each);
BENCHMARK_CAPTURE(six_fields, dis_medium, "dis", "medium", 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(six_fields, variational_quality, "variational", "quality", 0)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(six_fields, variational_fast, "variational", "fast", 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(six_fields, variational_fast_half, "variational", "fast", 1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace floatstage::render
