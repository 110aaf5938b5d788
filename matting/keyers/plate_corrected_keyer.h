#pragma once

#include <memory>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/keyers/keyer.h"

namespace floatstage::matting {

/// A keyer by colour ("chroma", "luminance"), corrected by photographs of the empty stage (empty_stage.h;
/// docs/adr/0342), picture by picture: fixtures go, and what no shadow can be becomes subject with hard
/// edges. A picture before which the plates do not stand (the camera was moved, the light has changed) is
/// keyed without them. The keyer itself comes back where there is nothing to correct with: it is none by
/// colour, or the plates are grey or of two sizes. Errors: those of learn_plate().
Result<std::unique_ptr<Keyer>> corrected_by_plate(std::unique_ptr<Keyer> keyer,
                                                  const std::vector<Image>& plates);

}  // namespace floatstage::matting
