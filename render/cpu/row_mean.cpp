#include "render/cpu/row_mean.h"

#include <algorithm>
#include <cmath>

#include "render/cpu/false_color.h"

namespace floatstage::render::cpu {

bool mark_weighty(const float* weight, float faint, std::size_t count, std::int32_t* marks) {
  std::int32_t any = 0;
  for (std::size_t i = 0; i < count; ++i) any |= marks[i] = weight[i] >= faint ? 1 : 0;
  return any != 0;
}

RowMean::RowMean(std::size_t count, float faint, RowMemory& memory)
    : count_(count), faint_(faint), sum_(memory.floats(4 * count)), total_(memory.floats(count)) {
  std::fill_n(sum_, 4 * count, 0.F);
  std::fill_n(total_, count, 0.F);
}

void RowMean::add(const RowShare& share) {
  for (std::size_t i = 0; i < count_; ++i) {
    const float weight = share.weight[i];
    if (weight < faint_) continue;
    for (std::size_t c = 0; c < 3; ++c) sum_[4 * i + c] += weight * share.color[4 * i + c];
    total_[i] += weight;
  }
}

const float* RowMean::finish(bool ghosts, std::span<const RowShare> shares) {
  constexpr float kNothing = 1e-12F;  // below what any photograph weighs
  for (std::size_t i = 0; i < count_; ++i)
    for (std::size_t c = 0; c < 3; ++c) sum_[4 * i + c] /= std::max(total_[i], kNothing);
  if (ghosts) show_ghosts(shares);
  return sum_;
}

void RowMean::show_ghosts(std::span<const RowShare> shares) {
  for (std::size_t i = 0; i < count_; ++i) {
    float* mean = sum_ + 4 * i;
    float apart = 0;
    for (const RowShare& share : shares) {
      if (!share.weight || share.weight[i] < faint_) continue;
      const float* color = share.color + 4 * i;
      apart += share.weight[i] / total_[i] *
               std::hypot(color[0] - mean[0], color[1] - mean[1], color[2] - mean[2]) / 255;
    }
    const std::array<float, 3> heat = heat_color(3 * apart);
    std::copy(heat.begin(), heat.end(), mean);
  }
}

}  // namespace floatstage::render::cpu
