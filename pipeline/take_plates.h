#pragma once

#include <filesystem>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// capture::plate_files() of the take's plates/.
std::vector<std::filesystem::path> plate_files(const capture::TakeReader& take, int camera);

/// capture::load_plates() of them, without what a camera or a converter added; those errors.
Result<std::vector<Image>> plates_of(const capture::TakeReader& take, int camera,
                                     std::size_t most = SIZE_MAX);

}  // namespace floatstage::pipeline
