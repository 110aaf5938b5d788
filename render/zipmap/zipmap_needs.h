#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "render/zipmap/zipmap.h"

namespace floatstage::render {

/// Where a picture of a zipmap's plane is seen from.
struct ZipmapView {
  Eigen::Matrix3d uv_from_pixel = Eigen::Matrix3d::Identity();  ///< as Zipmap::draw()
  int width = 0, height = 0;                                    ///< px
  Zipmap::Wrap wrap = Zipmap::Wrap::Clamp;
};

/// What a view needs of a patch.
struct PatchNeed {
  std::size_t patch = 0;
  std::size_t level = 0;  ///< the finest of its picture's that is sampled
  double pixels = 0;      ///< of the view that it covers, roughly
};

/// The patches that the view may show, in their order. None that it shows is missing, none of their levels is
/// too coarse; a patch close beside the view may be listed although it does not show.
std::vector<PatchNeed> needs_of(const Zipmap& zipmap, const ZipmapView& view);

}  // namespace floatstage::render
