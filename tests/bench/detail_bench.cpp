// The photo graph: nearest descriptors of two photographs against OpenCV's brute force, the same work in the
// same run; and the whole graph of ../shared/data/detail. Run: detail_bench

#include <benchmark/benchmark.h>
#include <opencv2/features2d.hpp>

#include "core/random.h"
#include "detail/nearest_descriptors.h"
#include "detail/photo_graph.h"

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
