#include "render/projected_images.h"

#include <algorithm>
#include <cstddef>

namespace floatstage::render {
namespace {

constexpr std::uint8_t kOwnAbove = 192;  // alpha: 255 own, 128 filled, 0 no proxy

ProjectedImages::State state_of(std::uint8_t alpha) {
  return alpha > kOwnAbove ? ProjectedImages::kOwn
         : alpha > 0       ? ProjectedImages::kFilled
                           : ProjectedImages::kNoProxy;
}

unsigned gray_of(const std::uint8_t* rgb) {
  return (77U * rgb[0] + 150U * rgb[1] + 29U * rgb[2] + 128U) >> 8;
}

}  // namespace

ProjectedImages projected_images(const std::vector<std::uint8_t>& rgba, int width, int height, int layers,
                                 int shrink) {
  ProjectedImages out;
  out.width = (width + shrink - 1) / shrink;
  out.height = (height + shrink - 1) / shrink;
  const std::size_t size = static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height);
  const std::size_t line = 4 * static_cast<std::size_t>(width),
                    picture = line * static_cast<std::size_t>(height);
  for (int layer = 0; layer < layers; ++layer) {
    std::vector<std::uint8_t> gray(size), state(size);
    const std::uint8_t* base = rgba.data() + static_cast<std::size_t>(layer) * picture;
    std::size_t i = 0;
    for (int y = 0; y < out.height; ++y) {
      const int y1 = std::min((y + 1) * shrink, height);
      for (int x = 0; x < out.width; ++x, ++i) {
        const int x1 = std::min((x + 1) * shrink, width);
        unsigned sum = 0, count = 0;
        std::uint8_t least = 255;
        for (int v = y * shrink; v < y1; ++v) {
          const std::uint8_t* from =
              base + line * static_cast<std::size_t>(v) + 4 * static_cast<std::size_t>(x * shrink);
          for (int u = x * shrink; u < x1; ++u, from += 4) {
            if (from[3] == 0) continue;
            sum += gray_of(from);
            least = std::min(least, from[3]);
            ++count;
          }
        }
        gray[i] = static_cast<std::uint8_t>(count > 0 ? (sum + count / 2) / count : 0);
        state[i] = count > 0 ? state_of(least) : ProjectedImages::kNoProxy;
      }
    }
    out.gray.push_back(std::move(gray));
    out.state.push_back(std::move(state));
  }
  return out;
}

}  // namespace floatstage::render
