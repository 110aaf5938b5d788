#include <benchmark/benchmark.h>

#include "calib/detect.h"
#include "tests/support/board_picture.h"

// One picture of 1280x720 px with the whole target, on one thread.
namespace floatstage::calib {
namespace {

void find(benchmark::State& state, const char* line, double distance) {
  const Result<TargetDesign> design = parse_target(line);
  const CameraModel camera = test::simple_camera(1280, 720, 60, BrownConrady{.k1 = -0.2, .k2 = 0.05});
  const Image picture = test::board_picture(
      *design, camera, test::before_camera(*design, distance, {20, 15, 5}), {.blur = 0.7, .noise = 2});
  std::size_t points = 0;
  for (auto _ : state) {
    const Detection found = detect(*design, picture);
    points = found.points.size();
    benchmark::DoNotOptimize(points);
  }
  state.counters["points"] = static_cast<double>(points);
}

BENCHMARK_CAPTURE(find, chessboard, "chessboard columns=8 rows=5 square=60mm", 0.9)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find, charuco, "charuco columns=5 rows=7 square=50mm marker=37.5mm dictionary=4x4_100", 0.9)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find, apriltags, "apriltags columns=4 rows=3 tag=66mm gap=19.8mm", 0.9)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find, wand, "wand positions=0mm,150mm,450mm ball=25mm", 2.0)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace floatstage::calib
