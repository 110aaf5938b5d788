// The photo graph: nearest descriptors of two photographs against OpenCV's brute force, the same work in the
// same run; the whole graph of ../shared/data/detail; and what
// a child costs to be carried over. Run: detail_bench

#include <benchmark/benchmark.h>
#include <opencv2/features2d.hpp>

#include "core/random.h"
#include "detail/blend_mask.h"
#include "detail/harmonic_fill.h"
#include "detail/nearest_descriptors.h"
#include "detail/photo_graph.h"
#include "detail/seam.h"
#include "tests/detail/pictures.h"

namespace floatstage::detail {
namespace {

constexpr int kFeatures = 4000;

PhotoFeatures noise(std::uint64_t seed) {
  Random random(seed);
  PhotoFeatures f;
  f.points.resize(kFeatures);
  for (int i = 0; i < kFeatures * PhotoFeatures::kLength; ++i)
    f.descriptors.push_back(static_cast<std::uint8_t>(random.next() % 150));
  return f;
}

void nearest_ours(benchmark::State& state) {
  const PhotoFeatures a = noise(1), b = noise(2);
  for (auto _ : state) benchmark::DoNotOptimize(nearest_both_ways(a, b));
}

// One direction only: it would have to be called twice.
void nearest_opencv(benchmark::State& state) {
  cv::setNumThreads(1);
  const PhotoFeatures a = noise(1), b = noise(2);
  cv::Mat of[2];
  for (int i = 0; i < 2; ++i) {
    const PhotoFeatures& f = i == 0 ? a : b;
    cv::Mat(kFeatures, PhotoFeatures::kLength, CV_8U, const_cast<std::uint8_t*>(f.descriptors.data()))
        .convertTo(of[i], CV_32F);
  }
  const cv::BFMatcher matcher(cv::NORM_L2);
  std::vector<std::vector<cv::DMatch>> found;
  for (auto _ : state) matcher.knnMatch(of[0], of[1], found, 2);
}

void graph_of_all(benchmark::State& state) {
  const std::filesystem::path folder = std::filesystem::path(FLOATSTAGE_DATA_DIR) / "detail";
  if (!std::filesystem::exists(folder)) return state.SkipWithError("the data is not on this machine");
  std::size_t photos = 0;
  for (auto _ : state) {
    GraphOptions options;
    options.relations.threads = static_cast<int>(state.range(0));
    const Result<PhotoGraph> graph = build_photo_graph(folder, options);
    if (!graph) return state.SkipWithError(graph.error().message.c_str());
    photos = graph->photos.size();
  }
  state.counters["photos"] = static_cast<double>(photos);
}

// A child of a million pixels and its parent, which differ a little everywhere.
struct Pictures {
  LightPicture child = to_light(test::photograph(1152, 868, test::view_of_world(0, 0, 1)));
  LightPicture parent = to_light(test::photograph(1152, 868, test::view_of_world(1, 0.5, 1.001)));
};

const Pictures& pictures() {
  static const Pictures made;
  return made;
}

// Three colours inside a seam of a hundred pixels from the edge.
void poisson_a_million(benchmark::State& state) {
  const Pictures& p = pictures();
  std::vector<std::uint8_t> fixed(p.child.pixels.size(), 1);
  for (int y = 100; y < p.child.height - 100; ++y)
    std::fill_n(fixed.begin() + static_cast<std::ptrdiff_t>(p.child.index(100, y)), p.child.width - 200, 0);
  if (state.range(0) == 0)  // all but the outermost pixels
    for (int y = 1; y + 1 < p.child.height; ++y)
      std::fill_n(fixed.begin() + static_cast<std::ptrdiff_t>(p.child.index(1, y)), p.child.width - 2, 0);
  int cycles = 0;
  for (auto _ : state) {
    LightPicture picture = p.child;
    cycles = fill_harmonically(picture, fixed);
  }
  state.counters["cycles"] = cycles;
}

void seam_of_a_child(benchmark::State& state) {
  const Pictures& p = pictures();
  const std::vector<std::uint8_t> same(p.child.pixels.size(), 1);
  for (auto _ : state) benchmark::DoNotOptimize(find_seam(p.child, p.parent, same));
}

void blending_mask_of_a_child(benchmark::State& state) {
  const std::vector<std::uint8_t> inside(pictures().child.pixels.size(), 1);
  for (auto _ : state) benchmark::DoNotOptimize(blending_mask(pictures().child, inside));
}

BENCHMARK(poisson_a_million)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(seam_of_a_child)->Unit(benchmark::kMillisecond);
BENCHMARK(blending_mask_of_a_child)->Unit(benchmark::kMillisecond);
BENCHMARK(nearest_ours)->Unit(benchmark::kMillisecond);
BENCHMARK(nearest_opencv)->Unit(benchmark::kMillisecond);
BENCHMARK(graph_of_all)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kSecond)
    ->Iterations(1)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace floatstage::detail
