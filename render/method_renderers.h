#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "render/renderer.h"

namespace floatstage::render {

/// Draws with whatever method is asked for: one renderer a method and back-end, made for its first picture
/// and kept. As a ViewRenderer: one thread at a time, with GL the GL thread.
class MethodRenderers {
 public:
  /// The picture belongs to the method's renderer and is valid until the method's next one. InvalidArgument
  /// for an unknown method, and as ViewRenderer::render().
  Result<RenderedView> render(const std::string& method, const Scene& scene, const View& view,
                              const RendererOptions& options);

 private:
  std::map<std::pair<std::string, BackEnd>, std::unique_ptr<ViewRenderer>> made_;
};

}  // namespace floatstage::render
