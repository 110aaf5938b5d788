#pragma once

#include <cstddef>

#include "core/image.h"

namespace floatstage::pipeline {

/// A mask as somebody painted it, as one channel: alpha where there is one, else brightness.
inline Image mask_of(const Image& picture) {
  if (picture.channels == 1) return picture;
  Image out(picture.width, picture.height, 1);
  const auto channels = static_cast<std::size_t>(picture.channels);
  for (std::size_t p = 0; p < out.pixels.size(); ++p)
    out.pixels[p] = picture.pixels[p * channels + (channels == 4 ? 3 : 1)];
  return out;
}

}  // namespace floatstage::pipeline
