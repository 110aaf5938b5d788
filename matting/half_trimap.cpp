#include "matting/half_trimap.h"

#include <algorithm>

namespace floatstage::matting {

Image half_trimap(const Image& trimap, int width, int height) {
  Image out(width, height, 1, 128);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int x0 = x * trimap.width / width, x1 = std::max(x0 + 1, (x + 1) * trimap.width / width);
      const int y0 = y * trimap.height / height, y1 = std::max(y0 + 1, (y + 1) * trimap.height / height);
      const std::uint8_t first = *trimap.at(x0, y0);
      bool all = first == 0 || first == 255;
      for (int v = y0; v < y1; ++v)
        for (int u = x0; u < x1; ++u) all = all && *trimap.at(u, v) == first;
      if (all) *out.at(x, y) = first;
    }
  }
  return out;
}

}  // namespace floatstage::matting
