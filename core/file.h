#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"

namespace floatstage {

/// The whole file as bytes in a string. NotFound or Io, naming the file.
Result<std::string> read_file(const std::filesystem::path& file);

/// Writes `bytes` to a temporary name beside `file`, flushes, and renames: readers see the old file or the
/// new one, never a half. Io names the file and the reason (disk full, permission); the temporary file is
/// removed.
Result<void> write_file(const std::filesystem::path& file, std::string_view bytes);

/// The temporary name that write_file() and every other writer of ours uses for `file`: hidden, same folder,
/// ends in ".tmp" before the extension, so that encoders still know the type.
std::filesystem::path temporary_name(const std::filesystem::path& file);

/// Makes a folder and those above it; one that is there already is fine. Io names the folder and the reason.
Result<void> make_folder(const std::filesystem::path& folder);

}  // namespace floatstage
