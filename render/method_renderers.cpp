#include "render/method_renderers.h"

namespace floatstage::render {

Result<RenderedView> MethodRenderers::render(const std::string& method, const Scene& scene, const View& view,
                                             const RendererOptions& options) {
  std::unique_ptr<ViewRenderer>& renderer = made_[{method, options.back_end}];
  if (!renderer) {
    Result<std::unique_ptr<ViewRenderer>> made = make_renderer(method, options.back_end);
    if (!made) return forward(made);
    renderer = std::move(*made);
  }
  return renderer->render(scene, view, options);
}

}  // namespace floatstage::render
