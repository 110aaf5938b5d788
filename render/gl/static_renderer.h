#pragma once

#include "render/renderer.h"

namespace floatstage::render {

/// "floating-static": see cpu/renderers.h.
Result<std::unique_ptr<ViewRenderer>> make_static_renderer();

}  // namespace floatstage::render
