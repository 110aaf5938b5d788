#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/color.h"

namespace floatstage::calib {

/// The colour of one surface point in one camera's picture; sRGB-like, 0..1, the mean of a few pixels.
struct ColorSample {
  int camera = 0, point = 0;
  Eigen::Vector3d seen = Eigen::Vector3d::Zero();
};

/// How one camera agrees with what the others see of the same points: CIEDE2000. Points that are off by far
/// more than most are other surfaces; they count as `strays` and in no mean.
struct ColorAgreement {
  int points = 0, strays = 0;
  double mean_before = 0, mean_after = 0, p95_after = 0;
};

struct ColorBalance {
  std::vector<ColorTransform> transforms;  ///< one a camera
  std::vector<ColorAgreement> cameras;
};

/// Transforms that make cameras agree on the points that several of them see. Cameras in `given` keep their
/// transform (a chart's, or the identity of the one that the others are to look like); at least one must be
/// given. The others are fitted one after the other, always the one that shares most points with those that
/// are done, and then twice again to the mean of all others. BadData names (by its index in `serials`) the
/// camera that shares too few points or too few colours with the others.
Result<ColorBalance> balance_colors(std::span<const ColorSample> sights,
                                    const std::vector<std::optional<ColorTransform>>& given,
                                    const std::vector<std::string>& serials);

}  // namespace floatstage::calib
