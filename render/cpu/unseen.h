#pragma once

#include <cstdint>
#include <vector>

#include "render/cpu/projection.h"
#include "render/image_fill.h"
#include "render/seen_pixels.h"

namespace floatstage::render::cpu {

/// What no camera of a view sees continues its surroundings: photographs show something else there. A view of
/// which nobody sees anything stays as it is.
/// The passes of render/gl/unseen.h; docs/adr/0363-what-nobody-sees-continues-its-surroundings.md.
class Unseen {
 public:
  /// After the picture of the projection's view is drawn, before it gets its opacity. How much of it is seen.
  SeenPixels run(Projection& projection, Image& picture);

 private:
  std::vector<std::uint8_t> known_;  // of the window without its margin: 255 where somebody sees it, else 0
  std::vector<SeenPixels> rows_;
  std::vector<float> values_;  // of the same: RGB
  PictureFill fill_;
};

}  // namespace floatstage::render::cpu
