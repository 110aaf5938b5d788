// The exact hull: milliseconds a phase, and how much slower the octree at 256^3 is on the same mattes. A real
// person where the shared data are there; a sphere and a torus everywhere.
//   exact_hull_bench --benchmark_min_time=2

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/statistics.h"
#include "recon/exact/exact_hull.h"
#include "recon/visual_hull.h"
#include "tests/recon/cone_views.h"
#include "tests/recon/real_sets.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/places.h"

namespace floatstage::recon {
namespace {

/// Drawn once: a bench's function is called several times, and drawing takes longer than what is measured.
const MatteSet& torus(int cameras) {
  static std::map<int, MatteSet> drawn;
  MatteSet& set = drawn[cameras];
  if (!set.mattes.empty()) return set;
  set.rig = shapes::ring_rig({.cameras = cameras, .distance = 3, .width = 640, .height = 480, .focal = 600});
  set.mattes = shapes::render_mattes(set.rig, shapes::torus({0.03, 0.02, 0.01}, 0.6, 0.2));
  return set;
}

double seconds_of(const MatteSet& set, const HullOptions& options, HullWorkspace& workspace) {
  const Result<HullReport> hull = visual_hull(set.rig, set.mattes, options, &workspace);
  return hull ? hull->seconds : std::numeric_limits<double>::quiet_NaN();
}

void measure(benchmark::State& state, const MatteSet& set, double tolerance, int threads,
             bool with_octree = true) {
  HullOptions options;
  options.contour_tolerance = tolerance;
  options.threads = threads;
  options.quality = false;
  HullWorkspace workspace;
  HullTimings sum;
  HullReport last;
  std::vector<double> frames;  // ms
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    const Result<void> ok = visual_hull(set.rig, set.mattes, options, workspace, last);
    if (!ok) return state.SkipWithError(ok.error().message.c_str());
    frames.push_back(1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    sum.contours += last.timings.contours;
    sum.tables += last.timings.tables;
    sum.rays += last.timings.rays;
    sum.faces += last.timings.faces;
    sum.weld += last.timings.weld;
    sum.triangles += last.timings.triangles;
  }
  const auto mean_ms = [](double seconds) {
    return benchmark::Counter(1e3 * seconds, benchmark::Counter::kAvgIterations);
  };
  state.counters["p50_ms"] = median(frames);
  state.counters["p95_ms"] = percentile(std::move(frames), 0.95);
  state.counters["contours_ms"] = mean_ms(sum.contours);
  state.counters["tables_ms"] = mean_ms(sum.tables);
  state.counters["rays_ms"] = mean_ms(sum.rays);
  state.counters["faces_ms"] = mean_ms(sum.faces);
  state.counters["weld_ms"] = mean_ms(sum.weld);
  state.counters["triangles_ms"] = mean_ms(sum.triangles);
  state.counters["faces"] = last.faces;
  state.counters["vertices"] = static_cast<double>(last.mesh.positions.size());
  const double views = static_cast<double>(set.rig.cameras.size());
  state.counters["points"] = static_cast<double>(last.work.points);
  // Constant where the cost is linear in outline points times views.
  state.counters["ns_per_point_and_view"] = benchmark::Counter(
      1e9 * sum.hull() / (views * static_cast<double>(last.work.points)), benchmark::Counter::kAvgIterations);
  if (!with_octree) return;
  // Ratio to the octree, both the best of a few in this run.
  double exact = std::numeric_limits<double>::infinity(), octree = exact;
  HullOptions slow;
  slow.method = HullMethod::Octree;
  slow.resolution = 256;
  slow.threads = threads;
  slow.quality = false;
  for (int k = 0; k < 5; ++k) exact = std::min(exact, seconds_of(set, options, workspace));
  for (int k = 0; k < 2; ++k) octree = std::min(octree, seconds_of(set, slow, workspace));
  state.counters["octree256_ratio"] = octree / exact;
}

void GreenDome(benchmark::State& state) {
  const std::filesystem::path folder = data_folder() / "green-dome";
  if (!std::filesystem::exists(folder)) return state.SkipWithError("the green dome is not on this machine");
  recon::MatteSet set = load_green_dome(folder);
  if (state.range(0) == 8) set = recon::subset(set, {0, 2, 5, 7, 10, 12, 15, 17});
  measure(state, set, static_cast<double>(state.range(1)) / 100, static_cast<int>(state.range(2)));
}
BENCHMARK(GreenDome)
    ->ArgNames({"cameras", "tolerance_percent", "threads"})
    ->Args({8, 100, 1})
    ->Args({8, 50, 1})
    ->Args({8, 50, 2})
    ->Args({8, 0, 1})
    ->Args({20, 50, 1})
    ->Args({20, 50, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// How the cost grows with the number of views.
void Torus(benchmark::State& state) {
  const int cameras = static_cast<int>(state.range(0));
  measure(state, torus(cameras), 0.5, 1, cameras <= 8);
}
BENCHMARK(Torus)
    ->ArgName("cameras")
    ->Arg(8)
    ->Arg(24)
    ->Arg(40)
    ->Arg(60)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// Toy-size sets: polygons of a sphere, no pixels.
void SphereCones(benchmark::State& state) {
  std::vector<ConeView> views;
  for (const Eigen::Vector3d& center : cones::around(8, 3)) {
    views.push_back(cones::of_sphere(center, 0.5, static_cast<int>(state.range(0)) / 8));
  }
  ExactHull engine;
  for (auto _ : state) {
    std::vector<ConeView> copy = views;
    benchmark::DoNotOptimize(engine.compute(copy, {}));
  }
  state.counters["vertices"] = static_cast<double>(engine.polygons().positions.size());
}
BENCHMARK(SphereCones)
    ->ArgName("edges")
    ->Arg(100)
    ->Arg(400)
    ->Arg(800)
    ->Arg(6400)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace floatstage::recon
