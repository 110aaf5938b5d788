#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"

namespace floatstage::capture {

/// Told how many more bytes were read; ends the work by answering no. Called from several threads.
using ReadWatch = std::function<bool(std::uint64_t bytes)>;

/// Bytes of a take's media and side files, sound and all: what sealing reads.
std::uint64_t recorded_bytes(const std::filesystem::path& take);

/// Writes the size and SHA-256 of every media and side file, and of sound.json, of a complete take into its
/// manifest: from then on check_take() knows every changed bit. A sealed take is left as it is. Errors: those
/// of reading the manifest; InvalidArgument for a take whose recording was cut off; NotFound, Io; Cancelled,
/// with the manifest as it was.
Result<void> seal_take(const std::filesystem::path& take, const ReadWatch& watch);

struct TakeCheck {
  bool sealed = false;                ///< by hash; otherwise by decoding every picture
  int files = 0;                      ///< looked at
  std::int64_t pictures = 0;          ///< decoded
  std::uint64_t bytes = 0;            ///< read
  std::vector<std::string> problems;  ///< a sentence each that names its file; none: as it was recorded
  std::vector<std::string> remarks;   ///< what is no damage: a cut, no seal
};

/// What of a recording is not as it was written. A sealed take's files are compared with their hashes; the
/// pictures of one that is not sealed are decoded, which finds what the codec's checksums find (FFV1: every
/// bit; raw and H.264: only what does not decode). Errors: NotFound when there is no take; Cancelled.
Result<TakeCheck> check_take(const std::filesystem::path& take, const ReadWatch& watch);

}  // namespace floatstage::capture
