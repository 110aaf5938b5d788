#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/result.h"

namespace floatstage::capture {

/// Where a take comes from that was not recorded itself: derived.json in its folder. Its media may be those
/// of the take that it was made from, the same files under a second name, and may then hold pictures that its
/// side files do not name.
struct Derivation {
  std::string from;  ///< the folder that it was made from, as it was said
  std::string how;   ///< "trim 10:20"
};

/// Absent for a take that was recorded. BadData for a file that is none of ours.
Result<std::optional<Derivation>> load_derivation(const std::filesystem::path& take);
Result<void> save_derivation(const Derivation& derivation, const std::filesystem::path& take);

}  // namespace floatstage::capture
