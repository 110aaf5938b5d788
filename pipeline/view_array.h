#pragma once

#include <vector>

#include "core/image.h"
#include "core/view.h"

namespace floatstage::pipeline {

/// Eyes in a row instead of one: two for stereo, more for displays that show several at once.
struct ViewArray {
  int views = 1;            ///< 1 to kMostViews
  double baseline = 0.065;  ///< metres from each eye to the next
};
inline constexpr int kMostViews = 8;

/// How the views' pictures stand in one: up to three in a row, more in two rows, from the leftmost eye on,
/// left to right, then down.
int columns_of(const ViewArray& array);
int rows_of(const ViewArray& array);

/// The views of the eyes, from the leftmost to the rightmost, around `middle`'s eye along its picture's rows.
/// All look the same way; their centres are moved so that what lies `distance` metres along the axis stands
/// at the same place in all pictures (parallel cameras with shifted frusta: turning them towards a point
/// would tilt rows against one another).
std::vector<View> views_of(const View& middle, const ViewArray& array, double distance);

/// The pictures of an array, of one size and as many channels, as one; see columns_of().
Image tiled(const std::vector<Image>& pictures, const ViewArray& array);

}  // namespace floatstage::pipeline
