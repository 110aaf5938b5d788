#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/flow.h"

namespace floatstage {

/// The intermediate images I_i^v on the CPU, as the flow needs them.
struct ProjectedImages {
  enum State : std::uint8_t { kNoProxy = 0, kFilled = 128, kOwn = 255 };
  int width = 0, height = 0;
  std::vector<std::vector<std::uint8_t>> gray;   ///< per image, width * height
  std::vector<std::vector<std::uint8_t>> state;  ///< per image and pixel: where the colour comes from
};

/// Per pixel of image `from`: is the flow `there` to image `to` to be believed? Both images must have their
/// own colour at both ends, `back` (may be null) must lead home, and the flow must make the images agree:
/// well, and better than no flow at all.
std::vector<bool> trusted(const ProjectedImages& images, std::size_t from, std::size_t to,
                          const FlowField& there, const FlowField* back);

}  // namespace floatstage
