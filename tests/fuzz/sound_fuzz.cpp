// Sound of a take. The first byte says which of its files the rest is: sound.json, name.sound.csv (with
// samples enough), or name.mka.

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "capture/sound/sound_reader.h"
#include "capture/sound/time_code.h"
#include "core/check.h"
#include "core/file.h"
#include "core/log.h"
#include "tests/fuzz/scratch_folder.h"

namespace floatstage::capture {
namespace {

void claim_tracks(std::string_view json) {
  const auto tracks = parse_sound_tracks(json, "fuzz");
  if (!tracks) return;
  for (const SoundTrack& track : *tracks) FLOATSTAGE_CHECK(check(track), "a track that no take holds");
  const auto again = parse_sound_tracks(to_json(*tracks), "again");
  FLOATSTAGE_CHECK(again && *again == *tracks, "tracks that change when they are written");
}

void claim_times(std::string_view csv) {
  const auto stamps = parse_sound_csv(csv, "fuzz");
  if (!stamps) return;
  std::string written = sound_csv_header();
  for (const SoundStamp& stamp : *stamps) written += to_csv(stamp);
  const auto again = parse_sound_csv(written, "again");
  FLOATSTAGE_CHECK(again && *again == *stamps, "times that change when they are written");
  constexpr std::int64_t kSamples = 1 << 20;
  const SoundClock clock(*stamps, 48'000, kSamples);
  std::int64_t last = 0;
  for (const SoundRun& run : clock.runs()) {
    FLOATSTAGE_CHECK(run.first >= last && run.end > run.first && run.end <= kSamples, "runs out of order");
    FLOATSTAGE_CHECK(run.rate > 47'900 && run.rate < 48'100, "a clock that nobody has");
    FLOATSTAGE_CHECK(std::isfinite(run.start_ns) && clock.end_of(run) > clock.start_of(run), "no time");
    last = run.end;
  }
}

void claim_time_code(std::string_view json) {
  const auto code = parse_time_code(json, "fuzz");
  if (!code) return;
  const auto again = parse_time_code(to_json(*code), "again");
  FLOATSTAGE_CHECK(again && *again == *code, "a time code that changes when it is written");
  FLOATSTAGE_CHECK(code->code_at(code->at) == code_of(code->frames, code->rate),
                   "another code at its anchor");
}

void claim_samples(std::string_view mka) {
  const std::filesystem::path folder = fuzz_folder();
  const TakeLayout take(folder);
  const SoundTrack track = {.name = "a", .rate = 8000, .channels = 2, .bits = 16, .from = "fuzz"};
  if (!write_file(folder / track.media(), mka) ||
      !write_file(folder / track.side_file(), sound_csv_header() + to_csv({0, {0}, 0})))
    return;
  const auto sound = SoundReader::open(take, track);
  if (!sound) return;
  std::array<float, 4096> levels = {};
  FLOATSTAGE_CHECK((*sound)->samples() >= 0 && (*sound)->read(-100, levels), "samples that cannot be read");
  FLOATSTAGE_CHECK((*sound)->read((*sound)->samples() - 100, levels), "samples that cannot be read");
  for (const float level : levels) FLOATSTAGE_CHECK(std::abs(level) <= 1, "louder than full scale");
  FLOATSTAGE_CHECK((*sound)->damage([](std::uint64_t) { return true; }), "damage that cannot be told");
}

}  // namespace
}  // namespace floatstage::capture

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  if (size == 0) return 0;
  log::set_level(log::Level::Off);
  const std::string_view rest(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 4 == 0) capture::claim_tracks(rest);
  if (data[0] % 4 == 1) capture::claim_times(rest);
  if (data[0] % 4 == 2) capture::claim_samples(rest);
  if (data[0] % 4 == 3) capture::claim_time_code(rest);
  return 0;
}
