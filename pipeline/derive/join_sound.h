#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// What of a take's sound goes into a joined one: from its first picture to the end of its last, moved by
/// `shift`.
struct SoundPart {
  const capture::TakeReader* take = nullptr;
  Timestamp first, end;
  Nanoseconds shift{0};
};

/// Writes the sound of takes into the folder of one: tracks of one name become one, a run each; samples stay
/// as they are. One whose rate or channels differ from the first of its name is left out with a note. Errors:
/// those of SoundReader and SoundWriter; Cancelled.
Result<void> join_sound(const std::vector<SoundPart>& parts, const TakeLayout& out,
                        std::vector<std::string>& notes, Progress* progress);

}  // namespace floatstage::pipeline
