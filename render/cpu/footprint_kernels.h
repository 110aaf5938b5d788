#pragma once

#include "render/cpu/photo_kernels.h"

namespace floatstage::render::cpu {

/// The square of the shorter axis of each pixel's footprint in a photograph, in pixels of it. The lens is
/// left out: it stretches pictures by a few per cent. Lists as in photo_kernels.h.
void footprints(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
                const Normals& normals, float* area);

}  // namespace floatstage::render::cpu
