#pragma once

#include <filesystem>
#include <vector>

#include "studio/messages/studio_control.h"

namespace floatstage::studio {

/// The takes in a folder, newest first by name, at most `most`. What is no take is not there.
std::vector<NodeTake> list_takes(const std::filesystem::path& folder, std::size_t most);

/// One of them; nothing where there is no take.
std::optional<NodeTake> look_at_take(const std::filesystem::path& folder);

}  // namespace floatstage::studio
