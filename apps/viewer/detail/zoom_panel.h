#pragma once

#include "apps/viewer/detail/zoom_input.h"
#include "apps/viewer/detail/zoom_scene.h"

struct ImDrawList;

namespace floatstage::apps {

/// The column at the left: what is shown, memory, photographs; one that is clicked is looked at.
void draw_zoom_controls(const ZoomScene& scene, const render::GlZipmap& zipmap,
                        const render::DrawnZipmap& drawn, ZoomState& state);

/// Photographs' outlines with their names over the picture.
void draw_outlines(ImDrawList* list, const ZoomScene& scene, const ZoomState& state);

}  // namespace floatstage::apps
