#pragma once

#include "render/renderer.h"

namespace floatstage::render {

/// "filtered": Filtered Blending (Eisemann, Error-Concealed Image-Based Rendering, ch. 10).
Result<std::unique_ptr<ViewRenderer>> make_filtered_renderer();

}  // namespace floatstage::render
