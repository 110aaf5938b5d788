#pragma once

#include "capture/added_file.h"
#include "capture/take.h"

namespace floatstage::pipeline {

/// What was added to a take's pictures (core/added_search.h), by looking at up to three instants of each
/// camera, twelve of fewer than three cameras, as `take` shows them; what cannot be read is not looked at.
/// Writes nothing. `threads`: 0: one per core.
capture::AddedFile search_added(capture::TakeReader& take, int threads);

}  // namespace floatstage::pipeline
