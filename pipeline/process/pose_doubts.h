#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Whether a camera stands otherwise than the take's rig says, by two instants of `frames` that have mattes
/// (check_silhouettes()), both together and, where that names nobody, the later one alone, which tells a
/// camera that was moved between them: a sentence for each camera that is named, with what to do. Nothing for
/// rigs of less than five cameras, where one matte that is off weighs as much as a pose, and where nothing
/// can be measured. Errors: Cancelled, and those of load_mattes().
Result<std::vector<std::string>> pose_doubts(const capture::TakeReader& take, const std::vector<int>& frames,
                                             int threads, Progress* progress);

}  // namespace floatstage::pipeline
