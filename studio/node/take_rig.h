#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::studio {

/// What a take's rig must fit: a camera and the pictures it streams.
struct LaneFacts {
  std::string serial;
  ImageLayout layout;
};

/// The rig of a new take, in the order of `lanes`: that of `file`, or made-up places on a ring where none is
/// given (empty). NotFound for a camera that the file does not have, InvalidArgument where it streams another
/// size than it was calibrated at; the errors of load_rig().
Result<Rig> rig_of_take(const std::filesystem::path& file, const std::vector<LaneFacts>& lanes);

}  // namespace floatstage::studio
