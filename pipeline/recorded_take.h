#pragma once

#include <filesystem>

#include "capture/take_check.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// capture::seal_take() and capture::check_take(), watched: a part of as many items as there are MiB to read.
Result<void> seal_take(const std::filesystem::path& take, Progress* progress);
Result<capture::TakeCheck> check_take(const std::filesystem::path& take, Progress* progress);

}  // namespace floatstage::pipeline
