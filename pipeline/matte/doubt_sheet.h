#pragma once

#include <filesystem>
#include <vector>

#include "capture/take.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Writes as `file` a contact sheet of one frame, and the folder for it: up to twelve of `cameras` (of the
/// rig) that have a photograph and a matte, each with the outline of its matte and, where three others have
/// one, of what they see. No file where no camera has both. Errors: those of writing; BadData of a matte that
/// cannot be read.
Result<void> save_doubt_sheet(capture::TakeReader& take, const std::vector<int>& cameras, int frame,
                              const std::filesystem::path& file);

}  // namespace floatstage::pipeline
