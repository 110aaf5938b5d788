#pragma once

#include <cstdint>
#include <vector>

#include "render/camera_choice.h"

namespace floatstage::render {

/// The intermediate images I_i^v on the CPU, as the flow needs them. Views that blend fewer images keep the
/// memory of the others.
struct ProjectedImages {
  enum State : std::uint8_t { kNoProxy = 0, kFilled = 128, kOwn = 255 };
  int width = 0, height = 0;
  using Pictures = ShortList<std::vector<std::uint8_t>, kMostListed>;
  Pictures gray;   ///< per image, width * height
  Pictures state;  ///< per image and pixel: where the colour comes from
};

/// Reads `layers` RGBA pictures as render/gl/shaders/project.comp writes them (alpha: where the colour comes
/// from), at 1/shrink of their size: grey is the mean of the pixels on the proxy, and a pixel is an image's
/// own only where all of those are.
ProjectedImages projected_images(const std::vector<std::uint8_t>& rgba, int width, int height, int layers,
                                 int shrink);

}  // namespace floatstage::render
