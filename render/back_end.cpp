#include "render/back_end.h"

#include "core/log.h"
#include "core/text.h"
#include "render/cpu/renderers.h"

namespace floatstage::render {

const std::vector<std::string>& back_end_names() {
  static const std::vector<std::string> names = {"auto", "cpu", "gl"};
  return names;
}

Result<BackEnd> parse_back_end(std::string_view name) {
  const std::vector<std::string>& names = back_end_names();
  for (std::size_t i = 0; i < names.size(); ++i)
    if (name == names[i]) return static_cast<BackEnd>(i);
  return fail(ErrorCode::InvalidArgument,
              text("--renderer '", name, "' is unknown; there are: auto, cpu, gl"));
}

Result<OpenBackEnd> open_back_end(BackEnd wanted) {
  if (wanted != BackEnd::Cpu) {
    Result<std::unique_ptr<GlContext>> gl = GlContext::headless();
    if (!gl && wanted == BackEnd::Gl) return forward(gl);
    if (gl && (wanted == BackEnd::Gl || !(*gl)->is_software())) {
      std::string description = (*gl)->description();
      return OpenBackEnd{BackEnd::Gl, std::move(*gl), std::move(description)};
    }
    log::info(text("drawing on the CPU (", cpu::description(),
                   "): ", gl ? text("OpenGL here is software, ", (*gl)->description()) : gl.error().message));
  }
  return OpenBackEnd{BackEnd::Cpu, nullptr, cpu::description()};
}

BackEnd back_end_in_window(BackEnd wanted, const GlContext& window) {
  if (wanted != BackEnd::Auto) return wanted;
  if (!window.is_software()) return BackEnd::Gl;
  log::info(
      text("drawing on the CPU (", cpu::description(), "): OpenGL here is software, ", window.description()));
  return BackEnd::Cpu;
}

}  // namespace floatstage::render
