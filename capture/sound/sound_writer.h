#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "capture/sound/sound_record.h"

namespace floatstage::capture {

/// Records one track of sound into a take's folder: <name>.mka and <name>.sound.csv, which must not exist.
/// sound.json is its caller's (save_sound_tracks(), before the first sample). Killed at any moment, what was
/// written plays up to the cut, of which two blocks are missing at most. Not thread safe.
class SoundWriter {
 public:
  /// InvalidArgument for a track that does not pass check(); Io names the file.
  static Result<std::unique_ptr<SoundWriter>> create(const TakeLayout& take, const SoundTrack& track);
  virtual ~SoundWriter() = default;
  /// Sample number `sample` (of what was or will be written) was taken at `time`. `new_run`: what was written
  /// before has no part in it. A stamp that does not follow the one before is left out. The first write() of
  /// a track comes after the stamp of sample 0.
  virtual Result<void> stamp(std::int64_t sample, Timestamp time, bool new_run = false) = 0;
  /// Samples of all channels in turn, -1 … 1; what is beyond, or no number, is cut to it or silent. Io names
  /// the file; what was written before stays.
  virtual Result<void> write(std::span<const float> interleaved) = 0;
  virtual std::int64_t samples() const = 0;  ///< written, of each channel
  /// Writes what waits and closes the files. Without it they end as a killed recording does.
  virtual Result<void> finish() = 0;
};

/// Samples in a block of FLAC, which is whole in the file before its stamps are: 21 ms at 48 kHz.
constexpr int kSoundBlock = 1024;

}  // namespace floatstage::capture
