#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "core/result.h"

namespace floatstage::calib {

/// Of a picture that no format states the size of.
struct PictureSizePx {
  int width = 0, height = 0;
};

/// What the header of a JPEG (ITU-T T.81, B.2.2) or PNG states; absent where it is neither.
std::optional<PictureSizePx> size_in_header(std::string_view bytes);

/// The same of a file. BadData when it is no whole JPEG or PNG.
Result<PictureSizePx> size_of_picture(const std::filesystem::path& picture);

}  // namespace floatstage::calib
