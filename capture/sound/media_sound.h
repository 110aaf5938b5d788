#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/time.h"

namespace floatstage::capture {

/// The sound of any file that libav knows: a video's sound track, a WAV, FLAC or BWF file. One thread at a
/// time.
class MediaSound {
 public:
  /// Absent when the file has no sound track. NotFound and Io as the operating system says, BadData when the
  /// file or its sound track cannot be read or states no rate or channels, or such as a take does not hold,
  /// or a WAV file holds less than it states; each names the file.
  static Result<std::unique_ptr<MediaSound>> open(const std::filesystem::path& file);
  virtual ~MediaSound() = default;

  virtual int rate() const = 0;      ///< samples a second
  virtual int channels() const = 0;  ///< 1 … kMostSoundChannels
  virtual int bits() const = 0;      ///< 16 or 24: what holds its samples
  struct Block {
    Nanoseconds time;            ///< of the first sample, in the file's own time: that of MediaReader::time()
    std::vector<float> samples;  ///< all channels in turn, -1 … 1; what was no number is silent
  };
  /// When its first sample was recorded, as the file says: seconds since midnight by its recorder's clock or
  /// time code (`time_reference` of a Broadcast Wave file, EBU Tech 3285). Absent where it says nothing.
  virtual std::optional<double> since_midnight() const = 0;
  /// The same as time code, hh:mm:ss:ff, of a rate that is not said (MOV, MP4, MXF).
  virtual std::optional<std::string> time_code() const = 0;
  /// The next samples; EndOfStream after the last. BadData when the track holds none at all, is damaged, or
  /// holds less than a FLAC file's header states.
  virtual Result<Block> next() = 0;
};

}  // namespace floatstage::capture
