#pragma once

#include <string>

#include "core/image.h"

namespace floatstage::apps {

/// Writes the picture to the first of floatstage-0.png, floatstage-1.png … that is not there, in the folder
/// that the program was started in. A line that says so, or why not.
std::string keep_screenshot(const Image& picture);

}  // namespace floatstage::apps
