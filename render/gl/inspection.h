#pragma once

#include "render/gl/projection.h"
#include "render/inspection.h"
#include "render/renderer_checks.h"

namespace floatstage::render {

/// Draws the intermediates that all renderers share (is_shared_intermediate()).
class Inspection {
 public:
  static Result<Inspection> create();
  void draw(const Projection& projection, const SceneTextures& textures, const Scene& scene, const View& view,
            const RendererOptions& options, const ViewTarget& target);

 private:
  gl::Kernel kernel_;
};

/// What render() returns once the target is drawn.
RenderedView rendered_view(const Scene& scene, const View& view, const Projection& projection,
                           const ViewTarget& target);

}  // namespace floatstage::render
