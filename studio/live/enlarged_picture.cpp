#include "studio/live/enlarged_picture.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace floatstage::studio {
namespace {

constexpr int kOne = 256;  // of a share

/// The two pixels around a place of the larger picture along one side, and the second's share.
struct Tap {
  int low, high, share;
};

Tap tap(int at, int size, int from) {
  const double place = (at + 0.5) * from / size - 0.5, floor = std::floor(place);
  const int low = static_cast<int>(floor);
  return {std::clamp(low, 0, from - 1), std::clamp(low + 1, 0, from - 1),
          static_cast<int>(std::lround((place - floor) * kOne))};
}

}  // namespace

void enlarge(const Image& picture, Image& out) {
  FLOATSTAGE_CHECK(picture.channels == 4 && out.channels == 4, "RGBA pictures");
  if (picture.empty()) return;
  for (int y = 0; y < out.height; ++y) {
    const Tap down = tap(y, out.height, picture.height);
    std::uint8_t* to = out.at(0, y);
    for (int x = 0; x < out.width; ++x, to += 4) {
      const Tap across = tap(x, out.width, picture.width);
      const std::uint8_t* from[4] = {picture.at(across.low, down.low), picture.at(across.high, down.low),
                                     picture.at(across.low, down.high), picture.at(across.high, down.high)};
      const int weights[4] = {(kOne - across.share) * (kOne - down.share), across.share * (kOne - down.share),
                              (kOne - across.share) * down.share, across.share * down.share};
      std::int64_t alpha = 0, color[3] = {0, 0, 0};
      for (int k = 0; k < 4; ++k) {
        const std::int64_t weight = static_cast<std::int64_t>(weights[k]) * from[k][3];
        alpha += weight;
        for (int c = 0; c < 3; ++c) color[c] += weight * from[k][c];
      }
      for (int c = 0; c < 3; ++c)
        to[c] = alpha > 0 ? static_cast<std::uint8_t>((color[c] + alpha / 2) / alpha) : from[0][c];
      to[3] = static_cast<std::uint8_t>((alpha + kOne * kOne / 2) / (kOne * kOne));
    }
  }
}

}  // namespace floatstage::studio
