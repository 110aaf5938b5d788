#include <benchmark/benchmark.h>

#include "pipeline/metrics/metrics.h"
#include "tests/pipeline/metrics/textures.h"

// Each score of one 640x480 picture pair whose mask is a person's size (a quarter of the width, four fifths
// high).
namespace floatstage::pipeline {
namespace {

template <double (*metric)(const Image&, const Image&, const Image&)>
void score_a_picture(benchmark::State& state) {
  const Image truth = texture(640, 480, 1, 2, 3), rendered = texture(640, 480, 2, 2, 3);
  const Image mask = box_mask(640, 480, 240, 48, 400, 432);
  double value = 0;
  for (auto _ : state) benchmark::DoNotOptimize(value = metric(rendered, truth, mask));
  state.counters["value"] = value;
}

BENCHMARK(score_a_picture<pipeline::psnr>)->Name("psnr")->Unit(benchmark::kMillisecond);
BENCHMARK(score_a_picture<pipeline::ssim>)->Name("ssim")->Unit(benchmark::kMillisecond);
BENCHMARK(score_a_picture<pipeline::cw_ssim>)->Name("cw_ssim")->Unit(benchmark::kMillisecond);
BENCHMARK(score_a_picture<pipeline::psnr_shift>)->Name("psnr_shift")->Unit(benchmark::kMillisecond);
BENCHMARK(score_a_picture<pipeline::sharpness>)->Name("sharpness")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace floatstage::pipeline
