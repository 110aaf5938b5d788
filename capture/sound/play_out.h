#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "capture/sound/sound_reader.h"

namespace floatstage::capture {

/// What is played at, films' and devices' usual rate.
constexpr int kPlayOutRate = 48'000;

/// A track as it is heard against the take's clock: resampled (libswresample) by what its own clock really
/// did, silent where it has no sound. One thread at a time.
class PlayOut {
 public:
  /// `channels`: those of the track that are heard, in this order; the reader outlives this.
  static Result<std::unique_ptr<PlayOut>> create(SoundReader& reader, const std::vector<int>& channels);
  virtual ~PlayOut() = default;
  /// What is read next was heard at `time`; from there on the take runs `speed` as fast as the samples
  /// are played, which is 1 to within what clocks differ by.
  virtual void seek(Timestamp time, double speed = 1) = 0;
  /// kPlayOutRate samples a second, all channels in turn. Io.
  virtual Result<void> read(std::span<float> interleaved) = 0;
};

}  // namespace floatstage::capture
