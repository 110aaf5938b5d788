#pragma once

#include <string>

#include "core/rig.h"
#include "pipeline/export/instant.h"

namespace floatstage::pipeline {

/// A frame of the page as the script that it loads: "frameLoaded(12, {…})" with mesh and sheet in base64.
/// Tiles are listed by camera of `rig` (the take's), of which the instant may have fewer.
std::string web_frame(const StraightInstant& instant, const Rig& rig, int number, int quality);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace floatstage::pipeline
