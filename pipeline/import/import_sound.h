#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/sound/sound_record.h"
#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Where a camera's video lies on the take's clock: the times that its first and its last imported picture
/// have in the video, and in the take.
struct VideoTimes {
  std::optional<Nanoseconds> first, last;
  Timestamp take_first, take_last;
};

/// A camera's video whose sound is to be kept.
struct VideoSound {
  std::string serial;
  std::filesystem::path video;
  VideoTimes times;
};

/// Writes the sound tracks of videos into the take in `folder`, each under its camera's serial, at the times
/// at which its pictures are: from a second before the first one to a second after the last. A video without
/// a sound track has none; one whose pictures play at another speed than it was recorded in, or that states
/// no times, is left out with a note. How many tracks there are. BadData for a sound track that is empty or
/// damaged; Io; Cancelled.
Result<int> import_sound(const std::vector<VideoSound>& videos, const std::filesystem::path& folder,
                         std::vector<std::string>& notes, Progress* progress);

}  // namespace floatstage::pipeline
