#include "core/synthetic/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/random.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3f;

// Normal deviates by table: one well-mixed 64-bit number is five indices into the quantiles of the
// distribution, which is ten times faster than Box-Muller and, at 4096 quantiles, indistinguishable once
// rounded to 8 bits.
constexpr int kTableBits = 12, kTableSize = 1 << kTableBits;

double normal_quantile(double p) {
  double low = -8, high = 8;  // by bisection on the error function
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
  }
  return (low + high) / 2;
}

std::vector<float> normal_table(double deviation) {
  std::vector<float> table(kTableSize);
  double squares = 0;
  for (int i = 0; i < kTableSize; ++i) {
    const double q = normal_quantile((i + 0.5) / kTableSize);
    table[static_cast<std::size_t>(i)] = static_cast<float>(q);
    squares += q * q;
  }
  const auto scale =
      static_cast<float>(deviation / std::sqrt(squares / kTableSize));  // the cut tails are made up for
  for (float& v : table) v *= scale;
  return table;
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 255.0f)));
}

}  // namespace

std::uint64_t key(std::uint64_t seed, std::uint64_t purpose, int camera, int frame) {
  std::uint64_t h = mix(seed + 0x9E3779B97F4A7C15u * purpose);
  h = mix(h ^ (static_cast<std::uint64_t>(static_cast<std::uint32_t>(camera)) << 32 |
               static_cast<std::uint32_t>(frame)));
  return mix(h + 0x9E3779B97F4A7C15u);
}

Vector3f SensorDefects::gain(int camera) const {
  if (defects.color_gain == 0) return Vector3f::Ones();
  Random random(key(seed, kGainKey, camera, 0));
  Vector3f gain;
  for (int c = 0; c < 3; ++c)
    gain[c] = static_cast<float>(std::max(0.1, 1 + defects.color_gain * random.normal()));
  return gain;
}

bool SensorDefects::dropped(int camera, int frame) const {
  return Random(key(seed, kDropKey, camera, frame)).uniform() < defects.dropped_frames;
}

Timestamp SensorDefects::exposure_start(int camera, int frame) const {
  double instant = frame / frame_rate;
  if (defects.time_jitter > 0) {
    const double limit = 0.45 / frame_rate;
    instant += std::clamp(defects.time_jitter * Random(key(seed, kJitterKey, camera, frame)).normal(), -limit,
                          limit);
  }
  return {std::max<std::int64_t>(0, std::llround(instant * 1e9))};
}

Image develop(const Exposure& exposure, const Vector3f& gain, double noise, std::uint64_t noise_seed) {
  Image image(exposure.width, exposure.height, 3);
  const std::vector<float> table = noise > 0 ? normal_table(noise) : std::vector<float>();
  const Vector3f scale = 255 * gain;
  for (std::size_t i = 0; i < exposure.color.size(); ++i) {
    const Vector3f value = exposure.color[i].cwiseProduct(scale);
    std::uint64_t bits = noise > 0 ? mix(noise_seed + 0x9E3779B97F4A7C15u * (i + 1)) : 0;
    for (int c = 0; c < 3; ++c) {
      const float deviate = noise > 0 ? table[static_cast<std::size_t>(bits & (kTableSize - 1))] : 0.0f;
      bits >>= kTableBits;
      image.pixels[3 * i + static_cast<std::size_t>(c)] = to_byte(value[c] + deviate);
    }
  }
  return image;
}

Image with_gain(const Image& plate, const Vector3f& gain) {
  Image image = plate;
  const Vector3f scale = 255 * gain;
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] =
        to_byte(static_cast<float>(plate.pixels[i]) / 255.0f * scale[static_cast<Eigen::Index>(i % 3)]);
  return image;
}

}  // namespace floatstage::synthetic
