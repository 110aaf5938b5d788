#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "render/gl_context.h"

namespace floatstage::render {

/// What draws pictures: native code for the processor, or OpenGL. Both draw the same (docs/adr/0165).
enum class BackEnd {
  Auto,  ///< Gl where a GPU draws, else Cpu
  Cpu,
  Gl,
};
const std::vector<std::string>& back_end_names();  ///< "auto", "cpu", "gl": in the enum's order
Result<BackEnd> parse_back_end(std::string_view name);

/// A back-end that is ready on the calling thread, as long as this lives.
struct OpenBackEnd {
  BackEnd back_end = BackEnd::Cpu;     ///< Cpu or Gl
  std::unique_ptr<GlContext> context;  ///< Gl: without a window, current on this thread; Cpu: null
  std::string description;  ///< for reports: instruction set and threads, or GL's vendor, renderer, version
};

/// Cpu needs nothing and asks for no OpenGL. Gl makes a context (errors: GlContext::headless()). Auto looks
/// for a GPU, takes Cpu where there is none, and logs which it took and why.
Result<OpenBackEnd> open_back_end(BackEnd wanted);

/// The same in a window, whose context is current: what `wanted` comes to. Logs what Auto took.
BackEnd back_end_in_window(BackEnd wanted, const GlContext& window);

}  // namespace floatstage::render
