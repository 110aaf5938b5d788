#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"

namespace floatstage::detail {

/// What of a photograph others are found by: SIFT keypoints (D. Lowe, "Distinctive Image Features from
/// Scale-Invariant Keypoints", IJCV 2004) of the picture shrunk to a longer side of at most 1,200 px.
struct PhotoFeatures {
  static constexpr int kLength = 128;     ///< numbers in a descriptor
  int width = 0, height = 0;              ///< of the photograph, px
  double scale = 1;                       ///< pixels of the photograph in one of the shrunk picture, >= 1
  std::vector<Eigen::Vector2d> points;    ///< px of the photograph, corners at whole numbers
  std::vector<float> sizes;               ///< diameter of what a descriptor looks at, px of the photograph
  std::vector<std::uint8_t> descriptors;  ///< points.size() x kLength

  int count() const { return static_cast<int>(points.size()); }
  const std::uint8_t* descriptor(int i) const {
    return descriptors.data() + static_cast<std::size_t>(i) * kLength;
  }
};

/// Finds at most `most` of them, the strongest. None in pictures of less than 16 px a side. `rgb`: 3
/// channels.
PhotoFeatures find_features(const Image& rgb, int most = 4000);

}  // namespace floatstage::detail
