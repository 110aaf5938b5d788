#pragma once

#include <initializer_list>
#include <memory>
#include <string_view>
#include <utility>

#include "render/gl/inspection.h"
#include "render/gl/projection.h"

namespace floatstage::render {

/// Makes a renderer that draws the projected surface in one pass: Renderer(first…, Projection, Inspection,
/// the kernel of that shader and the shader texts that it includes). Errors: those of the shaders.
template <class Renderer, class... First>
Result<std::unique_ptr<ViewRenderer>> make_blending_pass(std::string_view shader,
                                                         std::initializer_list<std::string_view> included,
                                                         First... first) {
  Result<Projection> projection = Projection::create();
  if (!projection) return forward(projection);
  Result<Inspection> inspection = Inspection::create();
  if (!inspection) return forward(inspection);
  Result<gl::Kernel> blend = gl::Kernel::create(shader, included);
  if (!blend) return forward(blend);
  return std::unique_ptr<ViewRenderer>(std::make_unique<Renderer>(first..., std::move(*projection),
                                                                  std::move(*inspection), std::move(*blend)));
}

}  // namespace floatstage::render
