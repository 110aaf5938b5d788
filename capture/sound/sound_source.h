#pragma once

#include <memory>
#include <string>
#include <vector>

#include "capture/sound/sound_record.h"

namespace floatstage::capture {

/// What a device delivered at once.
struct SoundPeriod {
  Timestamp time;              ///< of its first sample, on the studio clock
  bool new_run = false;        ///< samples before it were lost
  std::vector<float> samples;  ///< all channels in turn, -1 … 1
};

/// A device that records sound, from when it is opened on. One thread at a time.
class SoundSource {
 public:
  virtual ~SoundSource() = default;
  virtual int rate() const = 0;
  virtual int channels() const = 0;
  virtual int bits() const = 0;  ///< 16 or 24: what holds its samples
  /// The next samples, after a quarter of a second at most: Timeout. EndOfStream after a recording's last;
  /// Disconnected when the device is gone; Io, BadData.
  virtual Result<SoundPeriod> next() = 0;
};

inline constexpr const char* kSoundUsage =
    "alsa:DEVICE, file:PATH[?ppm=0&live=on] or tone:[HZ][?ppm=0&live=on]";

/// "alsa:hw:0": a device of ALSA, PipeWire's too ("alsa:default"). "file:PATH" plays a file as if it were a
/// device, "tone:" makes a tone (440 Hz); their clocks run `ppm` fast against the studio's, and with live=off
/// they deliver as fast as they are asked, from studio time 0 on. InvalidArgument for another URI; NotFound,
/// Io, BadData of what it names.
Result<std::unique_ptr<SoundSource>> open_sound(const std::string& uri);

/// How a track that is being recorded does.
struct SoundLevel {
  std::string name;
  double seconds = 0;  ///< recorded
  double peak = 0;     ///< 0 … 1 of full scale: the loudest now, falling by half in a sixth of a second
  bool ended = false;  ///< its device is gone, or its recording over
};

/// Records sources into a take that is being recorded, each on a thread of its own, as tracks "sound",
/// "sound2", … A source that ends or fails ends its track, which is said; the take goes on.
class SoundRecording {
 public:
  /// `uris` and `sources` belong together. Io: of the take's folder.
  static Result<std::unique_ptr<SoundRecording>> start(const TakeLayout& take,
                                                       const std::vector<std::string>& uris,
                                                       std::vector<std::unique_ptr<SoundSource>> sources);
  virtual ~SoundRecording() = default;  ///< as a killed recording where it was not finished
  /// Of each track, now. Any thread.
  virtual std::vector<SoundLevel> levels() const = 0;
  /// Until every source has ended by itself: of recordings.
  virtual void wait() = 0;
  /// Ends all tracks, and closes their files. The first error of a disk.
  virtual Result<void> finish() = 0;
};

}  // namespace floatstage::capture
