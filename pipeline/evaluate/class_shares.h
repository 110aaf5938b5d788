#pragma once

#include "core/image.h"

namespace floatstage::pipeline {

/// What plain blending does, as shares of a mask's pixels (>= 128): of a picture (RGBA) that a renderer hands
/// out as RenderOutput::Predicted or Measured. What is left is sharp. NaN where the mask is empty.
struct ClassShares {
  double blurred = 0, ghost = 0;
};
ClassShares class_shares(const Image& classes, const Image& mask);

}  // namespace floatstage::pipeline
