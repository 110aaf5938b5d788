#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "capture/sound/play_out.h"
#include "core/result.h"
#include "core/time.h"

namespace floatstage::capture {

/// A device that plays sound of two channels, kPlayOutRate samples a second by a clock of its own, silent
/// where nothing was written. Nothing here waits. One thread at a time.
class SoundOutput {
 public:
  virtual ~SoundOutput() = default;
  /// Samples of each channel that it takes now. Disconnected when the device is gone; Io.
  virtual Result<std::int64_t> room() = 0;
  /// Both channels in turn, -1 … 1, as many samples as there is room for at most.
  virtual Result<void> write(std::span<const float> interleaved) = 0;
  /// Of the samples that were written since the last drop(), those that have left the loudspeaker by now.
  virtual Result<std::int64_t> heard() = 0;
  /// Falls silent at once: what was written and not heard is forgotten.
  virtual void drop() = 0;
  /// Seconds since it was opened, for reports: of a file the place in it of what is heard now.
  virtual double clock() = 0;
};

constexpr int kOutputChannels = 2;
/// An output takes so much before it is heard, s: what a thread that is not scheduled may be late by.
constexpr double kOutputBuffer = 0.25;

inline constexpr const char* kSoundOutputUsage = "alsa:DEVICE, file:PATH[?ppm=0] or none:";

/// "alsa:default": a device of ALSA, PipeWire's too. "file:PATH" is one that is heard as a WAV file, silences
/// and all, by a clock that runs `ppm` fast; "none:" the same without a file. InvalidArgument for another
/// URI; NotFound, Io of what it names.
Result<std::unique_ptr<SoundOutput>> open_sound_output(const std::string& uri);
/// A "none:" whose time is `now()`.
std::unique_ptr<SoundOutput> silent_output(std::function<Timestamp()> now);

}  // namespace floatstage::capture
