#pragma once

#include <filesystem>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/result.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::apps {

nlohmann::json doubts_json(const std::vector<pipeline::MatteDoubt>& doubts);

nlohmann::json healed_json(const std::vector<pipeline::HealedCamera>& healed);

/// What `matte` and `process` end with where mattes cannot be trusted: BadData, with where to look.
Result<void> check_trusted(const std::filesystem::path& take,
                           const std::vector<pipeline::MatteDoubt>& doubts);

}  // namespace floatstage::apps
