#pragma once

#include <filesystem>
#include <system_error>

namespace floatstage {

/// Whether something has this name. What cannot be looked at (a link in a circle, a closed folder) counts:
/// who then reads it gets the reason in a sentence. Never throws, as std::filesystem::exists() does there.
inline bool is_there(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  return status.type() != std::filesystem::file_type::not_found;
}

/// Whether this is a folder, or leads to one; false where that cannot be known. Never throws.
inline bool is_folder(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

}  // namespace floatstage
