#pragma once

#include "render/renderer.h"

namespace floatstage::render {

/// "linear" and, with `one_camera`, "nearest": the projected photographs, blended as they are.
Result<std::unique_ptr<ViewRenderer>> make_blend_renderer(bool one_camera);

}  // namespace floatstage::render
