#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "core/result.h"

namespace floatstage::pipeline {

/// Writes a verb's --json report: indented, whole or not at all. NaN and infinity become null.
Result<void> save_json(const nlohmann::json& report, const std::filesystem::path& file);

}  // namespace floatstage::pipeline
