#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/color.h"
#include "core/image.h"
#include "core/result.h"

namespace floatstage::calib {

/// CIELAB (D65) of a colour in sRGB, 0..1.
Eigen::Vector3d lab_from_srgb(const Eigen::Vector3d& rgb);

/// CIEDE2000 colour difference of two CIELAB colours (Sharma, Wu & Dalal 2005, kL = kC = kH = 1). 1 is just
/// visible.
double delta_e_2000(const Eigen::Vector3d& lab_a, const Eigen::Vector3d& lab_b);

/// One colour as a camera saw it and as it should be; sRGB-like, 0..1.
struct ColorPair {
  Eigen::Vector3d seen = Eigen::Vector3d::Zero();
  Eigen::Vector3d wanted = Eigen::Vector3d::Zero();
};

struct ColorFit {
  ColorTransform transform;
  double mean_delta_e = 0, p95_delta_e = 0;  ///< CIEDE2000 over the pairs that were used, after the transform
  double mean_before = 0;                    ///< the same before it
  int used = 0;                              ///< pairs that are neither under- nor overexposed
};

/// Gain, 3x3 matrix and one curve a channel that bring `seen` to `wanted`: pairs from a chart, or from what
/// two cameras both see (some may be wrong: large differences count little). Pairs with a channel of `seen`
/// below 0.01 or above 0.99 are left out. BadData when fewer than 10 remain or they are all nearly one
/// colour.
Result<ColorFit> fit_color(std::span<const ColorPair> pairs);

/// Mean colours (sRGB-like, 0..1) of a 24-patch chart in an RGB picture, in the order of chart_colors().
/// NotFound when there is no chart. (OpenCV's `mcc`.)
Result<std::array<Eigen::Vector3d, 24>> find_color_chart(const Image& rgb);

/// The 24 patches of the classic chart as sRGB, 0..1: dark skin … black, row by row from the upper left
/// (nominal values).
const std::array<Eigen::Vector3d, 24>& chart_colors();

}  // namespace floatstage::calib
