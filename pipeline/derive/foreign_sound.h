#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "capture/sound/sound_record.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// A sound file of another recorder as tracks of a take: their times are the file's own, from 0 at its first
/// sample on.
struct ForeignSound {
  capture::SoundTrack track;
  std::int64_t samples = 0;
  std::optional<capture::SoundTrack> ltc;  ///< one channel of it, where it was asked for: not in `track`
  std::optional<double> since_midnight;    ///< its stamp (capture::MediaSound)
  std::optional<std::string> time_code;    ///< of the file's own time 0, as a film's pictures begin
  double first = 0;                        ///< s, of the file's own time, at the first sample
};

/// Decodes any file that libav knows, in a confined child, into `folder`, which must be empty: what it writes
/// into, nothing else is shared with it. `ltc`: the channel, from 0 on, that becomes a track of its own.
/// Errors, each naming the file: those of capture::MediaSound; BadData for a file without a sound track, with
/// silence only, or whose sound stops and goes on; InvalidArgument for a channel that it does not have; Io;
/// Cancelled.
Result<ForeignSound> copy_foreign_sound(const std::filesystem::path& file, const std::string& name,
                                        std::optional<int> ltc, const std::filesystem::path& folder,
                                        Progress* progress);

}  // namespace floatstage::pipeline
