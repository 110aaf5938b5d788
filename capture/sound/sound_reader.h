#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "capture/sound/sound_clock.h"
#include "capture/sound/sound_record.h"

namespace floatstage::capture {

/// A track of a take's sound, opened for random access. Thread safe.
class SoundReader {
 public:
  /// NotFound when one of its files is missing; BadData when they are not those of such a track; Io. A track
  /// that was cut off opens with warnings().
  static Result<std::unique_ptr<SoundReader>> open(const TakeLayout& take, const SoundTrack& track);
  virtual ~SoundReader() = default;

  virtual const SoundTrack& track() const = 0;
  virtual std::int64_t samples() const = 0;  ///< of each channel
  virtual const SoundClock& clock() const = 0;
  /// Sentences, each naming its file, about what is missing at its end.
  virtual const std::vector<std::string>& warnings() const = 0;
  /// Samples from `first` on, all channels in turn, as many as there is room for: exactly those that were
  /// recorded, and silence outside of the track and where a checksum says that it is damaged. Io.
  virtual Result<void> read(std::int64_t first, std::span<float> interleaved) = 0;
  /// Decodes everything: which samples are damaged, a sentence for each stretch. `go_on` is told how many
  /// more bytes were read and ends it with Cancelled by answering no. Io.
  virtual Result<std::vector<std::string>> damage(const std::function<bool(std::uint64_t bytes)>& go_on) = 0;
};

}  // namespace floatstage::capture
