#include <algorithm>
#include <cstring>

#include "render/cpu/projection.h"

namespace floatstage::render::cpu {
namespace {

unsigned gray_of(std::uint32_t rgba) {
  return (77U * (rgba & 255U) + 150U * (rgba >> 8 & 255U) + 29U * (rgba >> 16 & 255U) + 128U) >> 8;
}

}  // namespace

// As projected_images() makes them of pictures that GL drew.
void Projection::gray_images(int shrink, ProjectedImages& out) {
  out.width = (window_.width + shrink - 1) / shrink;
  out.height = (window_.height + shrink - 1) / shrink;
  const std::size_t size = static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height);
  out.gray.resize(choice_.chosen);
  out.state.resize(choice_.chosen);
  for (std::size_t i = 0; i < choice_.chosen; ++i) {
    out.gray[i].resize(size);
    out.state[i].resize(size);
  }
  parallel_for(choice_.chosen * static_cast<std::size_t>(out.height), threads_, [&](std::size_t item) {
    const std::size_t slot = item / static_cast<std::size_t>(out.height);
    const int row = static_cast<int>(item % static_cast<std::size_t>(out.height));
    std::uint8_t* gray =
        out.gray[slot].data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(out.width);
    std::uint8_t* state =
        out.state[slot].data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(out.width);
    std::fill_n(gray, out.width, std::uint8_t{0});
    std::fill_n(state, out.width, std::uint8_t{ProjectedImages::kNoProxy});
    const int first = row * shrink, last = std::min(first + shrink, window_.height);
    int low = window_.width, high = 0;
    for (int y = first; y < last; ++y) {
      const Covered::Row& covered = covered_.rows[static_cast<std::size_t>(y)];
      if (covered.count == 0) continue;
      low = std::min(low, covered_.spans[covered.first_span].begin);
      high = std::max(high, covered_.spans[covered.last_span - 1].end);
    }
    for (int x = low / shrink; x < (high + shrink - 1) / shrink; ++x) {
      unsigned sum = 0, count = 0, owned = 0;
      for (int v = first; v < last; ++v)
        for (int u = x * shrink; u < std::min((x + 1) * shrink, window_.width); ++u) {
          const std::size_t at = line(v) + static_cast<std::size_t>(u);
          if (inverse_z_[at] <= 0) continue;
          sum += gray_of(images_[slot][at]);
          owned += own_[at] >> slot & 1U;
          ++count;
        }
      if (count == 0) continue;
      gray[x] = static_cast<std::uint8_t>((sum + count / 2) / count);
      state[x] = owned == count ? ProjectedImages::kOwn : ProjectedImages::kFilled;
    }
  });
}

}  // namespace floatstage::render::cpu
