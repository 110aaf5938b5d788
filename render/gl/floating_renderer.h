#pragma once

#include "render/renderer.h"

namespace floatstage::render {

/// "floating": Floating Textures (Eisemann, Error-Concealed Image-Based Rendering, ch. 11).
Result<std::unique_ptr<ViewRenderer>> make_floating_renderer();

}  // namespace floatstage::render
