#pragma once

#include "render/renderer.h"

namespace floatstage::render {

/// "light-field": the four cameras of a grid around each viewing ray, bilinearly, through the proxy.
Result<std::unique_ptr<ViewRenderer>> make_light_field_renderer();

}  // namespace floatstage::render
