#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/flow.h"
#include "render/projected_images.h"

namespace floatstage::render {

/// Per pixel of image `from`: is the flow `there` to image `to` to be believed? Both images must have their
/// own colour at both ends, `back` (may be null) must lead home, and the flow must make the images agree:
/// well, and better than no flow at all.
std::vector<bool> trusted(const ProjectedImages& images, std::size_t from, std::size_t to,
                          const FlowField& there, const FlowField* back);

}  // namespace floatstage::render
