#pragma once

#include <span>
#include <vector>

#include "calib/color_balance.h"

namespace floatstage::calib {

struct GainBalance {
  std::vector<ColorTransform> transforms;  ///< one a camera: three gains; identity where too little is known
  std::vector<int> points;                 ///< one a camera: that it shares with others
  std::vector<bool> known;                 ///< one a camera: whether these are enough for gains
};

/// Three gains a camera that bring cameras to one another, however few colours they share: the mean of all is
/// left as it is. Where a chart or many colours are at hand, balance_colors() says more. Robust against
/// points that are no surface (medians), deterministic.
GainBalance balance_gains(std::span<const ColorSample> samples, std::size_t cameras);

}  // namespace floatstage::calib
