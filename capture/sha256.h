#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "core/result.h"

namespace floatstage::capture {

/// SHA-256 (FIPS 180-4) in lower-case hexadecimal: 64 characters.
std::string sha256(std::string_view bytes);

struct FileHash {
  std::uint64_t bytes = 0;
  std::string sha256;
};

/// Of a file's bytes, read in pieces; `go_on` is told how many more bytes were read, and ends it with
/// Cancelled by answering no. NotFound, Io.
Result<FileHash> sha256_of_file(const std::filesystem::path& file,
                                const std::function<bool(std::uint64_t bytes)>& go_on);

}  // namespace floatstage::capture
