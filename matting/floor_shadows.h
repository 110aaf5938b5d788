#pragma once

#include <span>
#include <vector>

#include "core/image.h"
#include "core/rig.h"

namespace floatstage::matting {

/// What a camera sees and what it sees of the empty stage: RGB, of one size, which may be smaller than the
/// camera's. Both or neither; not owned.
struct BeforeStage {
  const Image* picture = nullptr;
  const Image* stage = nullptr;
};

/// Shadows that somebody casts on the floor (z = 0), told by several cameras: a pixel is one where it is
/// darker than the empty stage, and more of the other cameras that see the same place of the floor show it
/// darker by as much there than show it as it was. However dark a shadow is and whatever its tint, all
/// cameras see it at one place; what stands on the floor hides another place from each, and most others see
/// that place as it was. Of a floor that is not at z = 0 nothing is found.
///
/// Of each camera a mask of its picture's size, 255 in shadows; empty without a picture. `cameras` are in rig
/// order. Deterministic at any thread count.
std::vector<Image> floor_shadows(const Rig& rig, std::span<const BeforeStage> cameras, int threads);

}  // namespace floatstage::matting
