// How fast one camera's pictures go to disk and come back: MB/s of RGB, and how small they become.

#include <cstdlib>
#include <filesystem>
#include <map>

#include <benchmark/benchmark.h>

#include "capture/take.h"
#include "core/synthetic/synthetic_studio.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

constexpr int kFrames = 24;

// The studio's performer with a sensor's noise: what a lossless codec has to carry.
const std::vector<Frame>& studio_frames(const Rig& rig) {
  static std::map<int, std::vector<Frame>> cache;
  std::vector<Frame>& frames = cache[rig.cameras[0].model.width];
  if (!frames.empty()) return frames;
  SyntheticStudioOptions options;
  options.samples = 4;
  options.defects.noise = 2;
  const SyntheticStudio studio = SyntheticStudio::create(rig, options).value();
  for (int k = 0; k < kFrames; ++k) frames.push_back(studio.shoot(0, k).frame);
  return frames;
}

Rig bench_rig(const benchmark::State& state) {
  SyntheticRigOptions options;
  options.cameras = 1;
  options.width = static_cast<int>(state.range(1));
  options.height = options.width * 3 / 4;
  return synthetic_rig(options);
}

void record(const std::filesystem::path& folder, const Rig& rig, TakeCodec codec) {
  TakeWriterOptions options;
  options.codec = codec;
  auto writer = TakeWriter::create(folder, rig, options).value();
  for (const Frame& frame : studio_frames(rig))
    if (!writer->write(frame)) std::abort();
  if (!writer->finish()) std::abort();
}

void report(benchmark::State& state, const Rig& rig, double frames) {
  const double bytes = 3.0 * rig.cameras[0].model.width * rig.cameras[0].model.height;
  state.counters["MB/s"] =
      benchmark::Counter(bytes * frames / 1e6, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["fps"] = benchmark::Counter(frames, benchmark::Counter::kIsIterationInvariantRate);
}

void write_take(benchmark::State& state) {
  const Rig rig = bench_rig(state);
  studio_frames(rig);
  double media = 0;
  for (auto _ : state) {
    const TempFolder folder;
    record(folder / "take", rig, static_cast<TakeCodec>(state.range(0)));
    state.PauseTiming();
    media =
        static_cast<double>(std::filesystem::file_size(folder / "take" / (rig.cameras[0].serial + ".mkv")));
    state.ResumeTiming();
  }
  report(state, rig, kFrames);
  state.counters["of raw"] =
      media / (3.0 * kFrames * rig.cameras[0].model.width * rig.cameras[0].model.height);
}

void read_take(benchmark::State& state) {
  const Rig rig = bench_rig(state);
  const TempFolder folder;
  record(folder / "take", rig, static_cast<TakeCodec>(state.range(0)));
  auto reader = TakeReader::open(folder / "take").value();
  for (auto _ : state)
    for (int k = 0; k < kFrames; ++k) benchmark::DoNotOptimize(reader->frame(0, k).value());
  report(state, rig, kFrames);
}

void seek_take(benchmark::State& state) {
  const Rig rig = bench_rig(state);
  const TempFolder folder;
  record(folder / "take", rig, static_cast<TakeCodec>(state.range(0)));
  auto reader = TakeReader::open(folder / "take").value();
  for (auto _ : state)
    for (int k = 0; k < kFrames; ++k)
      benchmark::DoNotOptimize(reader->frame(0, (k * 11 + 5) % kFrames).value());
  report(state, rig, kFrames);
}

void codecs_and_sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"codec", "width"})->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
  for (const TakeCodec codec : {TakeCodec::Ffv1, TakeCodec::Raw, TakeCodec::H264})
    for (const int width : {640, 1024}) bench->Args({static_cast<int>(codec), width});
}

BENCHMARK(write_take)->Apply(codecs_and_sizes);
BENCHMARK(read_take)->Apply(codecs_and_sizes);
BENCHMARK(seek_take)->Apply(codecs_and_sizes);

void open_long_take(benchmark::State& state) {
  const TempFolder folder;
  SyntheticRigOptions options;
  options.cameras = 1;
  options.width = options.height = 16;
  TakeWriterOptions raw;
  raw.codec = TakeCodec::Raw;
  auto writer = TakeWriter::create(folder / "take", synthetic_rig(options), raw).value();
  const auto pixels = std::make_shared<std::byte[]>(256);
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(state.range(0)); ++k) {
    Frame frame;
    frame.info.camera = 0;
    frame.info.sequence = k;
    frame.layout = packed_layout(PixelFormat::Gray8, 16, 16);
    frame.pixels = pixels;
    if (!writer->write(frame)) std::abort();
  }
  if (!writer->finish()) std::abort();
  for (auto _ : state) benchmark::DoNotOptimize(TakeReader::open(folder / "take").value());
}
BENCHMARK(open_long_take)->Arg(90'000)->Unit(benchmark::kMillisecond)->ArgName("frames");

}  // namespace
}  // namespace floatstage::capture
