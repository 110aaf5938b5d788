#pragma once

#include <memory>

#include "core/added_content.h"
#include "core/image.h"
#include "matting/keyers/keyer.h"

// Private to the stage.
namespace floatstage::matting {

/// The part of a picture inside the bars.
Image inside(const Image& picture, const AddedContent& bars);

/// A keyer that sees only what is inside the bars; they themselves are background. For pictures that come
/// straight from a camera: a take's reader hides what was added (capture/added_file.h).
std::unique_ptr<Keyer> inside_keyer(std::unique_ptr<Keyer> keyer, const AddedContent& bars);

}  // namespace floatstage::matting
