#pragma once

// Not a public header, since it names nlohmann-json: for the .cpp files that read documents of others.

#include <string_view>

#include <nlohmann/json.hpp>

#include "core/result.h"

namespace floatstage {

/// parse_json() for what came over the network or may have been written by anybody: BadData for documents of
/// more than `longest` bytes, or nested deeper than any of ours (16).
Result<nlohmann::json> parse_bounded(std::string_view json, std::string_view name_for_errors,
                                     std::size_t longest = 1 << 20);

}  // namespace floatstage
