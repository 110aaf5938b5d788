#pragma once

#include "render/gl/projection.h"
#include "render/renderer_checks.h"

namespace floatstage::render {

/// Draws the intermediates that all renderers share: weights, visibility, soft visibility, depth.
class Inspection {
 public:
  static Result<Inspection> create();
  bool shows(RenderOutput output) const;
  void draw(const Projection& projection, const SceneTextures& scene, const View& view,
            const ViewTarget& target) const;

 private:
  gl::Program program_;
};

/// What render() returns once the target is drawn.
RenderedView rendered_view(const Scene& scene, const View& view, const Projection& projection,
                           const ViewTarget& target);

}  // namespace floatstage::render
