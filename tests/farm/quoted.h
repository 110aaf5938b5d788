#pragma once

#include <filesystem>
#include <string>

namespace floatstage {

/// A path as one word of a shell.
inline std::string quoted(const std::filesystem::path& path) { return "'" + path.string() + "'"; }

}  // namespace floatstage
