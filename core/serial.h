#pragma once

#include <string_view>

namespace floatstage {

/// A camera's name without the extension of a picture or video that it was read from: "templeR0013" of
/// "templeR0013.png". Anything else stays. Takes made before serials were cut keep "templeR0013.png";
/// camera_index() finds a camera by either.
std::string_view without_media_extension(std::string_view name);

}  // namespace floatstage
