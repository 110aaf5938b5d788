#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "capture/take.h"
#include "pipeline/derive/derived_take.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

// By what a foreign recording finds its place in a take.
struct SoundAt {
  double seconds = 0;  ///< of its first sample, after the take's first picture
};
struct SoundAtCode {
  std::string code;  ///< of its first sample, as the take counts
};
/// Claps in it are those in the take's first sound track, or flashes in the pictures of its first camera.
struct SoundByClap {
  bool flash = false;
};
struct SoundByStamp {};  ///< its file says when it began, by the clock that the take's time code is of
struct SoundByLtc {
  int channel = 0;  ///< of the file, from 0 on: the take's time code
};
using SoundPlace = std::variant<SoundAt, SoundAtCode, SoundByClap, SoundByStamp, SoundByLtc>;

struct SetSoundOptions {
  std::filesystem::path take, file, out;
  SoundPlace place;
  std::string name;   ///< of the track; empty: the file's, without what a name may not have
  std::string label;  ///< of the new take; empty: as it was
  Progress* progress = nullptr;
};

struct SetSoundReport {
  DerivedReport take;
  capture::SoundTrack track;
  double begins = 0;   ///< s after the first picture
  double seconds = 0;  ///< that it lasts
  double ppm = 0;      ///< how much faster than the take's its clock ran, where several signs tell
  int signs = 0;       ///< claps or frames of time code that it was placed by; 0: it was said
  double spread = 0;   ///< s: the median of their distances from its clock
};

/// Makes `out` of a take, with a sound file of another recorder as its first track: a new take that shares
/// the media (derive_take()). The recorder's clock is its own: several claps, or time code, tell how fast it
/// ran. docs/adr/0278-sound-of-another-recorder.md
///
/// Errors: those of copy_foreign_sound() and derive_take(); InvalidArgument for a place that its take does
/// not know (no time code, no sound track), a name that is taken, or sound that lies beside all pictures;
/// NotFound where there is no clap, flash or stamp; BadData where they do not agree. Nothing is left behind
/// when it fails.
Result<SetSoundReport> set_sound(const SetSoundOptions& options);

}  // namespace floatstage::pipeline
