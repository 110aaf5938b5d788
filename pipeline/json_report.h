#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "core/result.h"

namespace floatstage::pipeline {

/// Writes a verb's --json report: indented, whole or not at all, in a folder that is made where it is
/// missing: a film of hours is not told to have been for nothing. NaN and infinity become null.
Result<void> save_json(const nlohmann::json& report, const std::filesystem::path& file);

}  // namespace floatstage::pipeline
