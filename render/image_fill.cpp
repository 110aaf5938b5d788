#include "render/image_fill.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace floatstage {
namespace {

struct Level {
  int width = 0, height = 0;
  std::vector<float> value, weight;  // value is a weighted sum until push() normalises it
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x); }
};

Level half(const Level& fine) {
  Level coarse;
  coarse.width = (fine.width + 1) / 2;
  coarse.height = (fine.height + 1) / 2;
  coarse.value.assign(static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height), 0);
  coarse.weight = coarse.value;
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      const std::size_t to = coarse.at(x / 2, y / 2), from = fine.at(x, y);
      coarse.value[to] += fine.weight[from] * fine.value[from];
      coarse.weight[to] += fine.weight[from];
    }
  }
  for (std::size_t i = 0; i < coarse.value.size(); ++i) {
    if (coarse.weight[i] <= 0) continue;
    coarse.value[i] /= coarse.weight[i];
    coarse.weight[i] = std::min(coarse.weight[i], 1.F);
  }
  return coarse;
}

float bilinear(const Level& level, float x, float y) {
  x = std::clamp(x, 0.F, static_cast<float>(level.width - 1));
  y = std::clamp(y, 0.F, static_cast<float>(level.height - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, level.width - 1), y1 = std::min(y0 + 1, level.height - 1);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const float top = level.value[level.at(x0, y0)] * (1 - fx) + level.value[level.at(x1, y0)] * fx;
  const float bottom = level.value[level.at(x0, y1)] * (1 - fx) + level.value[level.at(x1, y1)] * fx;
  return top * (1 - fy) + bottom * fy;
}

}  // namespace

void fill_unknown(int width, int height, const std::uint8_t* mask, std::uint8_t* gray) {
  std::vector<Level> levels(1);
  Level& base = levels.front();
  base.width = width;
  base.height = height;
  const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  base.value.resize(size);
  base.weight.resize(size);
  bool any = false;
  for (std::size_t i = 0; i < size; ++i) {
    base.value[i] = gray[i];
    base.weight[i] = mask[i] != 0 ? 1.F : 0.F;
    any = any || mask[i] != 0;
  }
  if (!any) return;
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(half(levels.back()));
  for (std::size_t l = levels.size() - 1; l-- > 0;) {
    Level& fine = levels[l];
    for (int y = 0; y < fine.height; ++y) {
      for (int x = 0; x < fine.width; ++x) {
        const std::size_t i = fine.at(x, y);
        if (fine.weight[i] >= 1) continue;
        const float coarse = bilinear(levels[l + 1], 0.5F * static_cast<float>(x) - 0.25F, 0.5F * static_cast<float>(y) - 0.25F);
        fine.value[i] = fine.weight[i] * fine.value[i] + (1 - fine.weight[i]) * coarse;
      }
    }
  }
  for (std::size_t i = 0; i < size; ++i)
    if (mask[i] == 0) gray[i] = static_cast<std::uint8_t>(std::clamp(std::lround(levels[0].value[i]), 0L, 255L));
}

}  // namespace floatstage
