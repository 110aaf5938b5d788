#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Settles what of a take's pictures no lens has seen (core/added_search.h), once: added.json says what was
/// found, and `take` is opened again where it hides something else from now on. `hide`: true looks for it
/// where that was not done yet, or left; false shows pictures as they were recorded from now on; absent: as
/// the take's file says, else true. Returns a sentence for cameras to whose pictures the same was added, of
/// what is hidden; for those who have claimed the take. Looks at up to three instants of each camera, twelve
/// of fewer than three cameras; what cannot be read is not looked at. Errors: those of added.json and of
/// opening the take.
Result<std::vector<std::string>> settle_added(std::unique_ptr<capture::TakeReader>& take,
                                              std::optional<bool> hide, int threads);

}  // namespace floatstage::pipeline
