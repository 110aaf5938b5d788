#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Whether a camera's pictures show other instants than the others' do, by half a frame or more, or always
/// the same one, from how silhouettes move in frames in a row of `frames` that have mattes
/// (measure_take_times(), quickly): a sentence for each such camera, with what to do. Nothing for fewer than
/// four cameras or twelve frames in a row, and where nothing moves. Errors: Cancelled, and those of
/// load_mattes().
Result<std::vector<std::string>> time_doubts(const capture::TakeReader& take, const std::vector<int>& frames,
                                             int threads, Progress* progress);

}  // namespace floatstage::pipeline
