// Closed form and cuts on one core, at the sizes that takes have. Compare within one run; counters say how
// much was unknown.
#include <algorithm>

#include <benchmark/benchmark.h>

#include "matting/video/closed_form_video.h"
#include "matting/video/segment_clip.h"
#include "tests/support/matte_clips.h"

namespace floatstage::matting {
namespace {

MatteClip clip(int width, int height) {
  return make_clip(studio_cutout(2), cluttered_place(width, height, 2),
                   {.width = width, .height = height, .frames = 12, .seed = 2});
}

// An edge refined against the photograph, as `matte --method closed-form` does with every key.
void refine(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0)), height = static_cast<int>(state.range(1));
  const MatteClip made = clip(width, height);
  RefineOptions options = key_refinement();
  options.band.margin = std::max(3, std::max(width, height) / 400);
  const Image band = trimap_around(made.truth[0], options.band);
  for (auto _ : state) benchmark::DoNotOptimize(refine_matte(made.frames[0], made.truth[0], options));
  state.counters["unknown"] = static_cast<double>(
      std::count_if(band.pixels.begin(), band.pixels.end(), [](int v) { return v != 0 && v != 255; }));
}
BENCHMARK(refine)->Args({360, 240})->Args({1024, 768})->Args({1920, 1088})->Unit(benchmark::kMillisecond);

// A small matte brought to a large photograph and refined there.
void refine_from_small(benchmark::State& state) {
  const MatteClip small = clip(360, 240), large = clip(1080, 720);
  for (auto _ : state) benchmark::DoNotOptimize(refine_matte(large.frames[0], small.truth[0]));
}
BENCHMARK(refine_from_small)->Unit(benchmark::kMillisecond);

// A frame of a clip that is carried from its first matte, flow included.
void carry(benchmark::State& state) {
  const MatteClip made = clip(360, 240);
  Result<ClosedFormVideo> video = ClosedFormVideo::create();
  std::size_t frame = 0;
  for (auto _ : state) {
    if (frame == 0) benchmark::DoNotOptimize(video->keyframe(made.frames[0], made.truth[0]));
    frame = frame % (made.frames.size() - 1) + 1;
    benchmark::DoNotOptimize(video->next(made.frames[frame]));
  }
}
BENCHMARK(carry)->Unit(benchmark::kMillisecond);

// A clip of twelve frames from one click: milliseconds for the whole of it.
void cut(benchmark::State& state) {
  const MatteClip made = clip(360, 240);
  MattingClip frames;
  frames.frames = static_cast<int>(made.frames.size());
  frames.photograph = [&](int f) -> Result<Image> { return made.frames[static_cast<std::size_t>(f)]; };
  MatteConstraint click{made.truth[0], made.truth[0]};
  for (std::uint8_t& w : click.weight.pixels) w = w == 255 ? 255 : 0;
  for (auto _ : state) benchmark::DoNotOptimize(segment_clip(frames, {{0, click}}));
}
BENCHMARK(cut)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace floatstage::matting
