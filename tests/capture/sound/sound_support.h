#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "capture/sound/sound_reader.h"
#include "capture/sound/sound_writer.h"
#include "tests/support/matchers.h"

namespace floatstage::capture {

/// Levels that 16 bits hold exactly, different for every sample and channel.
inline std::vector<float> patterned(std::int64_t first, std::int64_t samples, int channels) {
  std::vector<float> out;
  for (std::int64_t i = first * channels; i < (first + samples) * channels; ++i)
    out.push_back(static_cast<float>((i * 7919 + i * i % 1013) % 32768 - 16384) / 32768.f);
  return out;
}

/// A track of patterned() samples, stamped once a second by a clock that runs `ppm` fast.
inline void record(const TakeLayout& take, const SoundTrack& track, std::int64_t samples,
                   Timestamp begin = {0}, double ppm = 0) {
  ASSERT_THAT(save_sound_tracks({track}, take), IsOk());
  const auto writer = SoundWriter::create(take, track);
  ASSERT_THAT(writer, IsOk());
  const double period = 1e9 / (track.rate * (1 + ppm * 1e-6));
  for (std::int64_t at = 0; at < samples; at += track.rate) {
    const std::int64_t count = std::min<std::int64_t>(track.rate, samples - at);
    const Timestamp time = begin + Nanoseconds{std::llround(static_cast<double>(at) * period)};
    ASSERT_THAT((*writer)->stamp(at, time), IsOk());
    ASSERT_THAT((*writer)->write(patterned(at, count, track.channels)), IsOk());
  }
  ASSERT_THAT((*writer)->finish(), IsOk());
}

inline std::vector<float> read(SoundReader& sound, std::int64_t first, std::int64_t samples) {
  std::vector<float> out(static_cast<std::size_t>(samples * sound.track().channels), 9.f);
  EXPECT_THAT(sound.read(first, out), IsOk());
  return out;
}

}  // namespace floatstage::capture
