#pragma once

#include <memory>
#include <string>

#include "core/result.h"

namespace floatstage::render {

/// An OpenGL 4.5 core context that is current on the thread that made it, with our conventions set
/// (glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE)). Everything that draws with GL is used on that thread,
/// while it lives.
class GlContext {
 public:
  /// Without a window: EGL on a GPU's device platform where there is one, else surfaceless Mesa (llvmpipe).
  /// FLOATSTAGE_GL=software|device forces one; FLOATSTAGE_GL_DEBUG=1 logs what the driver says. Unsupported
  /// says what was tried and which package is missing.
  static Result<std::unique_ptr<GlContext>> headless();
  /// Takes the context that a window library has made current on this thread; does not own it.
  static Result<std::unique_ptr<GlContext>> adopt_current();

  virtual ~GlContext() = default;
  virtual std::string description() const = 0;  ///< vendor, renderer, version
  virtual bool is_software() const = 0;         ///< as is_software_gl()
};

/// Is the context that is current on this thread drawn by the CPU (llvmpipe and its like)?
bool is_software_gl();

}  // namespace floatstage::render
