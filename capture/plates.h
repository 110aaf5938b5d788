#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::capture {

/// Files with photographs of the empty stage by one camera: <serial>.png and <serial>/*.png of a folder, in
/// this order. Empty where nobody shot one.
std::vector<std::filesystem::path> plate_files(const std::filesystem::path& folder,
                                               const std::string& serial);

/// Up to `most` of those photographs, RGB or grey as they are, from the first on. BadData for a picture with
/// opacity; errors of files.
Result<std::vector<Image>> load_plates(const std::filesystem::path& folder, const std::string& serial,
                                       std::size_t most = SIZE_MAX);

}  // namespace floatstage::capture
