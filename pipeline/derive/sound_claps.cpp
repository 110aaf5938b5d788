#include "pipeline/derive/sound_claps.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/statistics.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kQuiet = 250;                 // ms before
constexpr std::size_t kOver = 250, kOverFor = 100;  // ms after
constexpr double kStandsOut = 100;                  // 20 dB, of power
constexpr double kFades = 10;                       // 10 dB
constexpr std::size_t kRise = 3;                    // ms within which it is loudest
constexpr float kFirst = 0.2F;                      // of the wave's height, where it begins
constexpr double kFaintest = 1e-8;                  // of full scale, a sample's power: 80 dB below it
constexpr std::size_t kMost = 200;
constexpr std::int64_t kChunkSeconds = 10;

/// The track as one wave of differences, which leave out rumble and wind.
class Wave {
 public:
  explicit Wave(capture::SoundReader& sound) : sound_(sound) {}

  Result<std::vector<float>> read(std::int64_t first, std::int64_t count) {
    const auto channels = static_cast<std::size_t>(sound_.track().channels);
    levels_.resize(static_cast<std::size_t>(count + 1) * channels);
    if (Result<void> ok = sound_.read(first - 1, levels_); !ok) return forward(ok);
    std::vector<float> wave;
    wave.reserve(static_cast<std::size_t>(count));
    float before = 0;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(count); ++i) {
      const auto from = levels_.begin() + static_cast<std::ptrdiff_t>(i * channels);
      const float now = std::accumulate(from, from + static_cast<std::ptrdiff_t>(channels), 0.F) /
                        static_cast<float>(channels);
      if (i > 0) wave.push_back(now - before);
      before = now;
    }
    return wave;
  }

 private:
  capture::SoundReader& sound_;
  std::vector<float> levels_;
};

// Mean power of a sample, a millisecond each.
Result<std::vector<double>> powers(capture::SoundReader& sound, std::int64_t block, Progress* progress) {
  Wave wave(sound);
  const std::int64_t blocks = sound.samples() / block, at_once = kChunkSeconds * 1000;
  ProgressPart part(progress, "claps", static_cast<std::size_t>((blocks + at_once - 1) / at_once));
  std::vector<double> out;
  for (std::int64_t k = 0; k < blocks; k += at_once) {
    if (is_cancelled(progress)) return cancelled();
    const std::int64_t some = std::min(at_once, blocks - k);
    const Result<std::vector<float>> levels = wave.read(k * block, some * block);
    if (!levels) return forward(levels);
    for (std::int64_t i = 0; i < some; ++i) {
      const auto from = levels->begin() + static_cast<std::ptrdiff_t>(i * block);
      out.push_back(std::inner_product(from, from + static_cast<std::ptrdiff_t>(block), from, 0.0) /
                    static_cast<double>(block));
    }
    part.advance();
  }
  return out;
}

double mean(const std::vector<double>& power, std::size_t first, std::size_t end) {
  end = std::min(end, power.size());
  if (first >= end) return 0;
  return std::accumulate(power.begin() + static_cast<std::ptrdiff_t>(first),
                         power.begin() + static_cast<std::ptrdiff_t>(end), 0.0) /
         static_cast<double>(end - first);
}

}  // namespace

Result<std::vector<SoundClap>> claps_in(capture::SoundReader& sound, Progress* progress) {
  const std::int64_t block = std::max(sound.track().rate / 1000, 1);
  const Result<std::vector<double>> power = powers(sound, block, progress);
  if (!power) return forward(power);
  const std::vector<double>& p = *power;
  if (p.size() <= kQuiet) return std::vector<SoundClap>();
  const double usual = std::max(median(p), kFaintest);
  std::vector<SoundClap> claps;
  for (std::size_t k = kQuiet; k < p.size(); ++k) {
    if (p[k] < kStandsOut * usual) continue;
    // What its wave began with may lie in the millisecond before.
    const double before = mean(p, k - kQuiet, k - 1);
    const auto end = std::min(k + kRise, p.size());
    const double loudest = *std::max_element(p.begin() + static_cast<std::ptrdiff_t>(k),
                                             p.begin() + static_cast<std::ptrdiff_t>(end));
    if (kStandsOut * before > loudest || kFades * mean(p, k + kOver, k + kOver + kOverFor) > loudest)
      continue;
    const std::int64_t from = (static_cast<std::int64_t>(k) - 1) * block;
    const Result<std::vector<float>> wave =
        Wave(sound).read(from, static_cast<std::int64_t>(kRise + 1) * block);
    if (!wave) return forward(wave);
    float height = 0;
    for (const float level : *wave) height = std::max(height, std::abs(level));
    const auto first = std::find_if(wave->begin(), wave->end(),
                                    [&](float level) { return std::abs(level) >= kFirst * height; });
    claps.push_back({from + (first - wave->begin()), std::sqrt(loudest)});
    k += kQuiet;
  }
  if (claps.size() > kMost) {
    std::nth_element(claps.begin(), claps.begin() + kMost, claps.end(),
                     [](const SoundClap& a, const SoundClap& b) { return a.strength > b.strength; });
    claps.resize(kMost);
    std::sort(claps.begin(), claps.end(),
              [](const SoundClap& a, const SoundClap& b) { return a.sample < b.sample; });
  }
  return claps;
}

}  // namespace floatstage::pipeline
