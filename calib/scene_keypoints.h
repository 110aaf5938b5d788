#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"

namespace floatstage::calib {

/// Places of a picture that can be told again in another one: SIFT (Lowe, Distinctive image features from
/// scale-invariant keypoints, 2004). The same picture gives the same keypoints. Private to calib.
struct SceneKeypoints {
  struct Keypoint {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< corner origin
    double size = 0, angle = 0;                       ///< px, radians
  };
  using Descriptor = std::array<std::int16_t, 128>;  ///< roots of shares (Arandjelovic and Zisserman 2012):
                                                     ///< length 512, each at most 255

  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;  ///< one a keypoint
};

/// `picture`: 1 or 3 channels. The strongest `most` keypoints of at least that contrast (of 1, as Lowe counts
/// it).
SceneKeypoints find_keypoints(const Image& picture, double contrast, int most = 8192);

}  // namespace floatstage::calib
