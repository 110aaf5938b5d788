#pragma once

#include "core/image.h"

// Private to the stage.
namespace floatstage::matting {

/// A trimap at a smaller size, in which a pixel is known only when everything in it is, and the same.
Image half_trimap(const Image& trimap, int width, int height);

}  // namespace floatstage::matting
