#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/result.h"

namespace floatstage::calib {

/// What a photograph's own file says of the lens that took it (EXIF 2.32, table 8; JPEG only). A start and no
/// measurement: makers round it, zooms and focus change it, and crops do not show in it.
struct ExifLens {
  /// Focal length over the longer side of the picture: of the 35 mm equivalent (36 mm wide), else of the
  /// focal length and the sensor's pitch.
  std::optional<double> focal_per_width;
  std::string camera;  ///< maker and model; empty when the file does not say
};

/// Of a whole JPEG file's bytes; any other file says nothing. Never fails on damaged bytes.
ExifLens exif_lens(std::string_view file);

}  // namespace floatstage::calib
