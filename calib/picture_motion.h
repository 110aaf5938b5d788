#pragma once

#include "core/image.h"

namespace floatstage::calib {

/// How one picture of a scene became another.
struct PictureMotion {
  int matches = 0;    ///< keypoints that both show
  double shift = 0;   ///< median displacement of these, as a share of the longer side
  double turned = 0;  ///< share of them that one homography explains: all of them where the camera only
                      ///< turned, or where the scene is a plane
};

/// Compares two pictures of one size, 1 or 3 channels, by keypoints of that contrast (MarkerlessOptions). The
/// same pictures give the same answer. Nothing is measured (all zero) where fewer than eight keypoints match.
PictureMotion picture_motion(const Image& from, const Image& to, double contrast);

}  // namespace floatstage::calib
