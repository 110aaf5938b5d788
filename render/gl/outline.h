#pragma once

#include "render/gl/kernel.h"
#include "render/renderer.h"

namespace floatstage::render {

class Projection;
class ViewTarget;
class SceneTextures;

/// How opaque a picture is at the proxy's outline. The passes of render/cpu/outline.h.
class Outline {
 public:
  static Result<Outline> create();

  /// Gives what was drawn into `target` with the projection's uniforms its opacity, or shows that, where the
  /// options want either.
  void soften(const Projection& projection, const SceneTextures& scene, const RendererOptions& options,
              ViewTarget& target);

 private:
  Outline() = default;
  void draw_samples(const Projection& projection, const SceneTextures& scene);

  gl::Program coverage_;
  gl::Kernel outline_;
  gl::Texture samples_;  // R8, four a pixel
  gl::Framebuffer samples_target_;
};

}  // namespace floatstage::render
