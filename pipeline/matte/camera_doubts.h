#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Why what the other cameras see is no evidence for a camera's mattes, a sentence each, with what to do: its
/// pictures are another's, upside down or mirrored (misplaced_cameras(), by two instants of `frames` that
/// have mattes), or, where none are, of other instants (time_doubts()). Errors: Cancelled, and those of
/// load_mattes() and load_occluders().
Result<std::vector<std::string>> camera_doubts(const capture::TakeReader& take,
                                               const std::vector<int>& frames, int threads,
                                               Progress* progress);

}  // namespace floatstage::pipeline
