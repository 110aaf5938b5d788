#pragma once

#include <filesystem>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Files with photographs of the empty stage by one camera: plates/<serial>.png and plates/<serial>/*.png, in
/// this order. Empty where nobody shot one.
std::vector<std::filesystem::path> plate_files(const capture::TakeReader& take, int camera);

/// Up to `most` of those photographs, RGB or grey as they are, from the first on, without what a camera or a
/// converter added. BadData for a picture with opacity; errors of files.
Result<std::vector<Image>> plates_of(const capture::TakeReader& take, int camera,
                                     std::size_t most = SIZE_MAX);

}  // namespace floatstage::pipeline
