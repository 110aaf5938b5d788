#include "pipeline/evaluate/class_shares.h"

#include <algorithm>
#include <limits>

namespace floatstage::pipeline {

ClassShares class_shares(const Image& classes, const Image& mask) {
  double pixels = 0;
  ClassShares shares;
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    if (mask.pixels[i] < 128) continue;
    const std::uint8_t* p = classes.pixels.data() + 4 * i;  // green sharp, blue blurred, red ghosts
    const int largest = std::max({p[0], p[1], p[2]});
    ++pixels;
    shares.ghost += p[0] == largest;
    shares.blurred += p[0] != largest && p[2] == largest;
  }
  if (pixels == 0)
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  return {shares.blurred / pixels, shares.ghost / pixels};
}

}  // namespace floatstage::pipeline
