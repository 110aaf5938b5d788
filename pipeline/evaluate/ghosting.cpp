#include "pipeline/evaluate/ghosting.h"

#include <limits>

namespace floatstage::pipeline {

double ghosting_of(const Image& heat, const Image& mask) {
  constexpr double kFull = 3 * 255, kGain = 3;  // as the renderers' heat maps: black, red, yellow, white
  double sum = 0, pixels = 0;
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    if (mask.pixels[i] < 128) continue;
    const std::uint8_t* p = heat.pixels.data() + 4 * i;
    sum += (p[0] + p[1] + p[2]) / kFull / kGain;
    ++pixels;
  }
  return pixels > 0 ? 255 * sum / pixels : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace floatstage::pipeline
