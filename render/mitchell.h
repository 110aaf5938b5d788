#pragma once

#include <cmath>

namespace floatstage::render {

/// The cubic filter of Mitchell and Netravali (1988), B = C = 1/3, of a distance in samples: 0 beyond 2.
inline float mitchell(float x) {
  x = std::abs(x);
  if (x < 1) return (7 * x * x * x - 12 * x * x + 16.F / 3) / 6;
  if (x < 2) return (((-7.F / 3 * x + 12) * x - 20) * x + 32.F / 3) / 6;
  return 0;
}
inline constexpr float kMitchellReach = 2;  ///< samples

}  // namespace floatstage::render
