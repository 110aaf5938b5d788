#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "core/image.h"
#include "core/synthetic/photograph.h"
#include "core/synthetic/synthetic_studio.h"

namespace floatstage::synthetic {

/// Everything random about one exposure is addressed by (seed, camera, frame), never by the order of calls.
struct SensorDefects {
  std::uint64_t seed = 1;
  Defects defects;
  double frame_rate = 25;

  /// Gain per channel: 1 + color_gain * normal, at least 0.1.
  Eigen::Vector3f gain(int camera) const;
  bool dropped(int camera, int frame) const;
  /// When the exposure really began. Jitter is cut at 0.45 frame periods, so that frames stay in order, and
  /// an exposure never begins before the clock does.
  Timestamp exposure_start(int camera, int frame) const;
};

/// Gain, noise and quantisation to 8 bits. Noise is addressed by (seed, camera, frame, pixel).
Image develop(const Exposure& exposure, const Eigen::Vector3f& gain, double noise, std::uint64_t noise_seed);

/// The same gain and quantisation for an 8-bit picture, without noise.
Image with_gain(const Image& plate, const Eigen::Vector3f& gain);

/// A number for (seed, purpose, camera, frame).
std::uint64_t key(std::uint64_t seed, std::uint64_t purpose, int camera, int frame);

inline constexpr std::uint64_t kGainKey = 1, kDropKey = 2, kJitterKey = 3, kNoiseKey = 4, kCalibrationKey = 5;

}  // namespace floatstage::synthetic
