#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.h"

namespace floatstage::apps {

/// "640x480" → {640, 480}; both positive and at most 16384.
Result<std::pair<int, int>> parse_size(std::string_view text);

/// "a,b,c" → parts, empty ones left out.
std::vector<std::string> split_list(std::string_view text);

/// "5", "2:10" or "2:10:4" (end exclusive; either may be left out) → frame numbers inside [0, count); "" →
/// all.
Result<std::vector<int>> parse_frames(std::string_view text, int count);

/// "rrggbb" → 0 … 1 a channel; for --background.
Result<std::array<float, 3>> parse_color(std::string_view text);

}  // namespace floatstage::apps
