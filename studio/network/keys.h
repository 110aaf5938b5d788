#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/result.h"

namespace floatstage::studio::wire {

/// The studio's CURVE keys, as 40 letters each (Z85). One pair for the whole studio: every machine of it has
/// the same file, proves with it that it belongs to the studio, and talks to nobody who does not.
struct StudioKeys {
  std::string public_key, secret_key;
  bool operator==(const StudioKeys&) const = default;
};

/// New keys from the system's randomness.
Result<StudioKeys> make_keys();

/// Writes a file that only its owner can read (0600). AlreadyExists where there is one: keys in use are not
/// lost.
Result<void> save_keys(const StudioKeys& keys, const std::filesystem::path& file);

/// InvalidArgument when others may read the file: then the keys are no secret. BadData when it is no file of
/// keys, or the two do not belong together.
Result<StudioKeys> load_keys(const std::filesystem::path& file);

/// Whether an address ("tcp://127.0.0.1:5570") may be used: InvalidArgument for one that other machines
/// reach, unless there are keys; and for what is no address.
Result<void> check_address(const std::string& address, const std::optional<StudioKeys>& keys);

}  // namespace floatstage::studio::wire
