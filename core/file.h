#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"

namespace floatstage {

/// No file that is read whole is larger.
constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 30;

/// The whole file as bytes in a string. NotFound or Io (which it is too when this is no regular file),
/// BadData when it has more than `most` bytes; each names the file.
Result<std::string> read_file(const std::filesystem::path& file, std::uint64_t most = kLargestFile);

/// Writes `bytes` to a temporary name beside `file`, flushes, and renames: readers see the old file or the
/// new one, never a half, however many write it at once. Io names the file and the reason (disk full,
/// permission); the temporary file is removed.
Result<void> write_file(const std::filesystem::path& file, std::string_view bytes);

/// The temporary name of what takes long to write (core/claim.h claims it): hidden, same folder, ends in
/// ".tmp" before the extension, so that encoders still know the type. write_file() adds numbers of its own.
std::filesystem::path temporary_name(const std::filesystem::path& file);

/// Whether this is a name of either kind.
bool is_temporary(const std::filesystem::path& file);

/// Makes a folder and those above it; one that is there already is fine. Io names the folder and the reason.
Result<void> make_folder(const std::filesystem::path& folder);

}  // namespace floatstage
