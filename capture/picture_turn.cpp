#include "capture/picture_turn.h"

#include <algorithm>

namespace floatstage::capture {

std::optional<PictureTurn> turn_of(const std::int32_t* m) {
  const std::int32_t xx = m[0], xy = m[1], yx = m[3], yy = m[4];  // xy: what x adds to the new y
  if (xx != 0 && yy != 0 && xy == 0 && yx == 0) return PictureTurn{false, xx < 0, yy < 0};
  if (xx == 0 && yy == 0 && xy != 0 && yx != 0) return PictureTurn{true, yx < 0, xy < 0};
  return std::nullopt;
}

Image turned(const Image& image, const PictureTurn& turn) {
  const int width = turn.swap_axes ? image.height : image.width,
            height = turn.swap_axes ? image.width : image.height;
  Image out(width, height, image.channels);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int u = turn.backwards_x ? width - 1 - x : x, v = turn.backwards_y ? height - 1 - y : y;
      const std::uint8_t* from = turn.swap_axes ? image.at(v, u) : image.at(u, v);
      std::copy_n(from, image.channels, out.at(x, y));
    }
  }
  return out;
}

}  // namespace floatstage::capture
