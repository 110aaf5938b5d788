#pragma once

// Private to capture/: a display matrix, as containers and EXIF hold it, applied to pixels.

#include <cstdint>
#include <optional>

#include "core/image.h"

namespace floatstage::capture {

/// One of the eight ways to put a picture upright: columns and rows swapped or not, each axis then run
/// backwards or not.
struct PictureTurn {
  bool swap_axes = false;
  bool backwards_x = false, backwards_y = false;
  bool operator==(const PictureTurn&) const = default;
};

/// libav's 3×3 display matrix (16.16 fixed point, row vectors: (x' y') = (x y) M). Nothing when it is none of
/// the eight.
std::optional<PictureTurn> turn_of(const std::int32_t* display_matrix);

Image turned(const Image& image, const PictureTurn& turn);

}  // namespace floatstage::capture
