#pragma once

#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// A contact sheet of one frame: up to twelve of `cameras` (of the rig) that have a photograph and a matte,
/// each with the outline of its matte and, where three others have one, of what they see. Empty where no
/// camera has both. Errors: BadData of a matte that cannot be read.
Result<Image> doubt_sheet(capture::TakeReader& take, const std::vector<int>& cameras, int frame);

}  // namespace floatstage::pipeline
