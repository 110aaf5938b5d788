#pragma once

#include <array>

#include "render/cpu/outline.h"
#include "render/cpu/projection.h"
#include "render/cpu/unseen.h"

namespace floatstage::render::cpu {

/// The picture a renderer hands out: RGBA8 of the view's size, the background with alpha 0 where the proxy is
/// not.
class Picture {
 public:
  void begin(const View& view, const std::array<float, 3>& background);
  const Image& image() const { return image_; }

  /// Writes a row of the window: rgb (0…255, three or four floats a pixel) for its covered pixels, opaque.
  /// What lies outside the view is left out.
  void write(const Projection& projection, int y, const float* rgb, int floats);

  /// Once all rows are written: continues the view's surroundings where no camera sees it and gives it its
  /// opacity, or shows that, where the options want either. `sees`: the colours are those of cameras that see
  /// what they show.
  /// Cancelled when the picture was given up.
  Result<void> soften(Projection& projection, const RendererOptions& options, bool sees = true);
  /// What soften() found to be seen; none where it did not ask.
  const SeenPixels& seen() const { return seen_; }

 private:
  Image image_;
  SeenPixels seen_;
  Unseen unseen_;
  Outline outline_;
};

/// What render() returns once the picture is drawn.
RenderedView rendered_view(const Scene& scene, const View& view, const Projection& projection,
                           const Picture& picture);

}  // namespace floatstage::render::cpu
