#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/rig.h"

namespace floatstage {

/// rig.json: {"floatstage_rig": 1, "cameras": [{"serial", "width", "height", "fx", "fy", "cx", "cy", "skew",
/// "lens": {"type": "none"|"brown-conrady"|"kannala-brandt", …}, "cam_from_world": {"rotation_wxyz",
/// "translation"}, "color_matrix", "color_curve"}]}, the last only where there is a curve: then the version
/// is 2. Numbers survive a round trip bit by bit. The result has passed check(rig).
Result<Rig> parse_rig(std::string_view json, std::string_view name_for_errors);
std::string to_json(const Rig& rig);

Result<Rig> load_rig(const std::filesystem::path& file);
/// Writes to a temporary name and renames; replaces an existing file only when it can be replaced whole.
Result<void> save_rig(const Rig& rig, const std::filesystem::path& file);

}  // namespace floatstage
