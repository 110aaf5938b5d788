#pragma once

#include <algorithm>

#include "core/image.h"

namespace floatstage::test {

/// The upper half of what a matte (1 channel) shows is gone.
inline void cut_upper_half(Image& matte) {
  int top = matte.height, bottom = 0;
  for (int y = 0; y < matte.height; ++y)
    if (std::any_of(matte.at(0, y), matte.at(0, y) + matte.width, [](std::uint8_t a) { return a >= 128; }))
      top = std::min(top, y), bottom = y;
  std::fill(matte.pixels.begin(),
            matte.pixels.begin() + static_cast<std::ptrdiff_t>(matte.offset(0, (top + bottom) / 2)), 0);
}

}  // namespace floatstage::test
