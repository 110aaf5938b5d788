// The photo graph: nearest descriptors of two photographs against OpenCV's brute force, the same work in the
// same run; the whole graph of ../shared/data/detail; what a child costs to be carried over; and what details
// cost that are made up, neighbours against FLANN's single kd-tree. Run: detail_bench

#include <benchmark/benchmark.h>
#include <opencv2/features2d.hpp>
#include <opencv2/flann/flann_base.hpp>

#include "core/parallel.h"
#include "core/random.h"
#include "detail/blend_mask.h"
#include "detail/harmonic_fill.h"
#include "detail/nearest_descriptors.h"
#include "detail/photo_graph.h"
#include "detail/seam.h"
#include "detail/synthesis/nearest_points.h"
#include "detail/synthesis/neighbourhoods.h"
#include "detail/synthesis/synthesis.h"
#include "tests/detail/pictures.h"
#include "tests/support/places.h"

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
  const std::filesystem::path folder = data_folder() / "detail";
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

/// Neighbourhoods of one half of a picture, looked for in the other.
struct Searched {
  int dimensions = 0;
  std::vector<float> points, places;
  std::vector<float> third;  // the exact third distance of each place
};

const Searched& searched() {
  static const Searched made = [] {
    const ColorGrid colors = to_colors(test::photograph(1024, 1024, test::view_of_world(0, 0, 0.7)));
    Grid<std::uint8_t> all(colors.region, 1);
    const Neighbourhoods basis(colors, all);
    Searched s;
    s.dimensions = basis.dimensions();
    std::vector<float> one(static_cast<std::size_t>(s.dimensions));
    for (int y = 2; y < 1022; ++y)
      for (int x = 2; x < 1022; ++x) {
        std::vector<float>& to = x < 512 ? s.points : s.places;
        if (x >= 512 && (x % 5 != 0 || y % 5 != 0)) continue;
        basis.project(colors, x, y, one.data());
        to.insert(to.end(), one.begin(), one.end());
      }
    const NearestPoints tree(s.points, s.dimensions);
    NearestPoints::Found found[3];
    for (std::size_t i = 0; i < s.places.size(); i += one.size()) {
      tree.find(&s.places[i], 3, 0, found);
      s.third.push_back(found[2].distance);
    }
    return s;
  }();
  return made;
}

// Recall: the share of what is found that lies within the exact third distance.
void count_recall(benchmark::State& state, const std::vector<float>& distances) {
  std::size_t within = 0;
  for (std::size_t i = 0; i < distances.size(); ++i)
    within += distances[i] <= searched().third[i / 3] * 1.0001F;
  state.counters["recall"] = static_cast<double>(within) / static_cast<double>(distances.size());
  state.counters["queries/s"] = benchmark::Counter(static_cast<double>(searched().third.size()),
                                                   benchmark::Counter::kIsIterationInvariantRate);
  state.counters["dimensions"] = searched().dimensions;
}

void neighbours_ours(benchmark::State& state) {
  const Searched& s = searched();
  const NearestPoints tree(s.points, s.dimensions);
  std::vector<float> distances(3 * s.third.size());
  const auto slack = static_cast<float>(state.range(0)) / 10;
  for (auto _ : state)
    for (std::size_t i = 0; i < s.third.size(); ++i) {
      NearestPoints::Found found[3];
      tree.find(&s.places[i * static_cast<std::size_t>(s.dimensions)], 3, slack, found);
      for (std::size_t k = 0; k < 3; ++k) distances[3 * i + k] = found[k].distance;
    }
  count_recall(state, distances);
}

void neighbours_flann(benchmark::State& state) {
  const Searched& s = searched();
  const auto d = static_cast<std::size_t>(s.dimensions);
  using Distance = cvflann::L2<float>;
  const cvflann::Matrix<float> points(const_cast<float*>(s.points.data()), s.points.size() / d, d);
  cvflann::KDTreeSingleIndex<Distance> index(points, cvflann::KDTreeSingleIndexParams(32, true));
  index.buildIndex();
  std::vector<float> distances(3 * s.third.size());
  std::vector<int> found(3);
  const cvflann::SearchParams search(32, static_cast<float>(state.range(0)) / 10, true);
  for (auto _ : state)
    for (std::size_t i = 0; i < s.third.size(); ++i) {
      cvflann::KNNSimpleResultSet<float> result(3);
      result.init(found.data(), &distances[3 * i]);
      index.findNeighbors(result, &s.places[i * d], search);
    }
  count_recall(state, distances);
}

// A child of 512 x 512 pixels in a picture of 2048 x 2048, 16 times as large as its root.
Synthesis synthesis_of_2048(int threads) {
  const Image close = test::photograph(512, 512, test::view_of_world(600, 600, 0.7));
  DetailLayer layer{Image(512, 512, 4, 255), 860, 860, 4, false};
  for (std::size_t i = 0; i < close.pixels.size() / 3; ++i)
    std::copy_n(&close.pixels[3 * i], 3, &layer.picture.pixels[4 * i]);
  SynthesisOptions options;
  options.threads = threads;
  return *Synthesis::make(test::photograph(128, 128, test::view_of_world(0, 0, 0.7 * 16)), {layer}, options);
}

void synthesis_of_the_first_tile(benchmark::State& state) {
  synthesis_of_2048(1);  // the made photographs are not what is measured
  for (auto _ : state) benchmark::DoNotOptimize(synthesis_of_2048(1).tile({256, 1536, 512, 1792}));
}

void synthesis_of_a_further_tile(benchmark::State& state) {
  const Synthesis synthesis = synthesis_of_2048(1);
  for (auto _ : state) benchmark::DoNotOptimize(synthesis.tile({256, 1536, 512, 1792}));
}

void synthesis_of_all_tiles(benchmark::State& state) {
  const auto threads = static_cast<int>(state.range(0));
  for (auto _ : state) {
    const Synthesis synthesis = synthesis_of_2048(threads);
    parallel_for(64, threads, [&](std::size_t i) {
      const int x = static_cast<int>(i % 8) * 256, y = static_cast<int>(i / 8) * 256;
      benchmark::DoNotOptimize(synthesis.tile({x, y, x + 256, y + 256}));
    });
  }
}

BENCHMARK(neighbours_ours)->Arg(0)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond);
BENCHMARK(neighbours_flann)->Arg(0)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond);
BENCHMARK(synthesis_of_the_first_tile)->Unit(benchmark::kSecond);
BENCHMARK(synthesis_of_a_further_tile)->Unit(benchmark::kSecond);
BENCHMARK(synthesis_of_all_tiles)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kSecond)
    ->Iterations(1)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
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
