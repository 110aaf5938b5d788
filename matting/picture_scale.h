#pragma once

#include "core/image.h"

// Private to the stage.
namespace floatstage {

/// The picture at another size: area means when it shrinks, bicubic when it grows. The picture itself when the size fits.
Image scaled(const Image& picture, int width, int height);

}  // namespace floatstage
