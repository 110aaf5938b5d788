#pragma once

#include "matting/keyers/keyer.h"

// Private to the stage.
namespace floatstage::matting {

/// clean_up() (keyer.h) on labels of 32 bits a pixel: slower, and of any radius. clean_up() and BitCleanUp
/// are tested against it.
Image clean_up_by_labels(const Image& alpha, const CleanupOptions& options);

}  // namespace floatstage::matting
