#pragma once

#include <vector>

#include "render/camera_choice.h"
#include "render/short_list.h"

namespace floatstage::render {

/// In which directions the images of a view move where the proxy is wrong by some depth along the viewing ray
/// (docs/algorithms/floating-textures.md#positions). Of each image a plane of `width` * `height`, as
/// ProjectedImages: px by which it stands beside its place where the images of a pair are moved by 1 px
/// against one another, in the mean over pairs. 0 where nothing is seen or no image has parallax.
struct Parallaxes {
  int width = 0, height = 0;
  using Planes = ShortList<std::vector<float>, kMostListed>;
  Planes x, y;
  /// How far the surface lies off the proxy, along its normal and in units of the world, where they stand so:
  /// what displacements of different views of one place are compared by.
  std::vector<float> offset;
  /// How much each image counts, by its fade, with sum 1; a pair by the product. So one that comes or goes
  /// does so with weight 0.
  ShortList<float, kMostListed> share;
};

}  // namespace floatstage::render
