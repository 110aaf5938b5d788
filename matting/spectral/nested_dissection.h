#pragma once

#include <vector>

// Private to the stage.
namespace floatstage::matting {

/// The order in which to eliminate the pixels of a grid whose neighbours reach two rows and columns far:
/// halves of a rectangle first, the two pixels wide line between them last, recursively (George, "Nested
/// dissection of a regular finite element mesh", 1973). order[i] is the pixel (y * width + x) that is
/// eliminated i-th.
std::vector<int> nested_dissection(int width, int height);

}  // namespace floatstage::matting
