#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/take_layout.h"
#include "core/time.h"

namespace floatstage::capture {

/// One recording of sound in a take: <name>.mka (FLAC in Matroska) holds its samples as they were recorded,
/// <name>.sound.csv says when.
struct SoundTrack {
  std::string name;   ///< as a camera's serial (is_usable_serial())
  int rate = 48'000;  ///< samples a second, as the device calls it
  int channels = 1;
  int bits = 24;     ///< of a sample: 16 or 24
  std::string from;  ///< where it came from: "clip.mp4", "alsa:hw:0"
  bool operator==(const SoundTrack&) const = default;

  std::string media() const { return name + ".mka"; }
  std::string side_file() const { return name + ".sound.csv"; }
};

constexpr int kMostSoundChannels = 8;  // FLAC's
constexpr int kLowestSoundRate = 8'000, kHighestSoundRate = 192'000;

/// Whether a take can hold it; InvalidArgument says what is wrong.
Result<void> check(const SoundTrack& track);

/// A row of <name>.sound.csv: sample number `sample` was taken at `time`, on the take's clock. A `run` is
/// sound without a gap: samples of another run may lie anywhere in time.
struct SoundStamp {
  std::int64_t sample = 0;
  Timestamp time;
  int run = 0;
  bool operator==(const SoundStamp&) const = default;
};

/// sound.json: {"floatstage_sound": 1, "tracks": [{"name", "rate", "channels", "bits", "from"}]}. BadData;
/// Unsupported for a format of a later program.
Result<std::vector<SoundTrack>> parse_sound_tracks(std::string_view json, std::string_view name_for_errors);
std::string to_json(const std::vector<SoundTrack>& tracks);

std::filesystem::path sound_file(const TakeLayout& take);
/// A take's sound; none where it has no sound.json.
Result<std::vector<SoundTrack>> load_sound_tracks(const TakeLayout& take);
Result<void> save_sound_tracks(const std::vector<SoundTrack>& tracks, const TakeLayout& take);
/// The track of this name, of a take's; the first for "". NotFound names those that there are.
Result<SoundTrack> sound_track_named(const std::vector<SoundTrack>& tracks, const std::string& name);

/// "sample,studio_time_ns,run\n" and rows. Samples grow, runs begin with 0 and grow by one, times grow within
/// a run. A last line without its newline is ignored; any other malformed line is BadData with its number.
std::string sound_csv_header();
std::string to_csv(const SoundStamp& stamp);
Result<std::vector<SoundStamp>> parse_sound_csv(std::string_view csv, std::string_view name_for_errors);

}  // namespace floatstage::capture
