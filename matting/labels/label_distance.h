#pragma once

#include <functional>
#include <vector>

// Private to the stage.
namespace floatstage::matting {

inline constexpr float kFarAway = 1e4F;  // px

/// px from each pixel to the nearest one that is `there`; kFarAway without any.
std::vector<float> distance_to(int width, int height, const std::function<bool(int x, int y)>& there);

}  // namespace floatstage::matting
