#pragma once

#include <memory>

#include "render/gl_context.h"

namespace floatstage::render {

/// The context that all benches of a program draw with, current on the first caller's thread; null where
/// there is no OpenGL 4.5.
inline const GlContext* context() {
  static const Result<std::unique_ptr<GlContext>> made = GlContext::headless();
  return made ? made->get() : nullptr;
}

}  // namespace floatstage::render
