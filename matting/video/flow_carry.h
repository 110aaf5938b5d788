#pragma once

#include "core/image.h"

// Private to the stage.
namespace floatstage::matting {

/// A matte of one frame brought to a neighbouring one along dense flow (DIS, Kroeger et al. 2016).
struct Carried {
  Image matte;  ///< 1 channel, of the new frame's size
  Image doubt;  ///< 1 channel: 255 where the flow there and back do not meet or colours changed: nothing is
                ///< known there
};

/// `from`, `to`: RGB of one size (at least 16x16), `matte` of theirs.
Carried carry_matte(const Image& from, const Image& matte, const Image& to);

}  // namespace floatstage::matting
