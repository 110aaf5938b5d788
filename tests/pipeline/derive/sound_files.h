#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

/// Files of sound, as other recorders write them.
namespace floatstage::pipeline {

template <class T>
std::string wav_bytes(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Levels of all channels in turn as 16-bit PCM.
inline std::string pcm16(const std::vector<float>& levels) {
  std::string out;
  for (const float level : levels)
    out += wav_bytes(static_cast<std::int16_t>(std::lround(std::fmin(std::fmax(level, -1.f), 1.f) * 32767)));
  return out;
}

/// A WAV file; with `since_midnight` (samples) a Broadcast Wave file (EBU Tech 3285).
inline std::string wav_file(const std::vector<float>& levels, int channels, int rate,
                            std::int64_t since_midnight = -1) {
  const std::string data = pcm16(levels);
  const std::string format = wav_bytes(std::uint16_t{1}) + wav_bytes(static_cast<std::uint16_t>(channels)) +
                             wav_bytes(rate) + wav_bytes(rate * channels * 2) +
                             wav_bytes(static_cast<std::uint16_t>(channels * 2)) +
                             wav_bytes(std::uint16_t{16});
  std::string chunks = "WAVE";
  if (since_midnight >= 0) {
    std::string bext(602, '\0');
    std::memcpy(bext.data() + 338, &since_midnight, sizeof since_midnight);
    chunks += "bext" + wav_bytes(std::uint32_t{602}) + bext;
  }
  chunks += "fmt " + wav_bytes(std::uint32_t{16}) + format + "data" +
            wav_bytes(static_cast<std::uint32_t>(data.size())) + data;
  return "RIFF" + wav_bytes(static_cast<std::uint32_t>(chunks.size())) + chunks;
}

}  // namespace floatstage::pipeline
