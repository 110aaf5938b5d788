#pragma once

#include <string_view>

#include "core/image.h"

namespace floatstage::pipeline {

/// Prints `words` (letters, digits, '-') into an RGB picture, white on a dark strip, its upper left corner at
/// (x, y); as large as suits a picture `of_height` pixels high. What does not fit is cut off.
void label(Image& rgb, int x, int y, int of_height, std::string_view words);

}  // namespace floatstage::pipeline
