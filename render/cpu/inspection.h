#pragma once

#include "render/cpu/picture.h"
#include "render/inspection.h"

namespace floatstage::render::cpu {

/// Draws an intermediate that all renderers share (is_shared_intermediate()) from what the projection knows.
void draw_intermediate(Projection& projection, const Scene& scene, const View& view,
                       const RendererOptions& options, Picture& picture);

/// How wide a photograph's pixels are in the view, px, over row y whose normals are `normals`: the longer
/// axis of their projections (Eq. 9.4-9.6). Lists of the row.
void pixel_spacings(const Projection& projection, std::size_t slot, int y, const Normals& normals,
                    float* spacing);

}  // namespace floatstage::render::cpu
