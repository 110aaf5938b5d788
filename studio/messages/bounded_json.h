#pragma once

#include <string_view>

#include <nlohmann/json.hpp>

#include "core/result.h"

namespace floatstage::studio::wire {

/// parse_json() for what came over the network: BadData for documents larger or deeper than any of ours.
Result<nlohmann::json> parse_bounded(std::string_view json, std::string_view name_for_errors);

}  // namespace floatstage::studio::wire
