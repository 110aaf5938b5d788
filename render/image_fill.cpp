#include "render/image_fill.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace floatstage::render {
namespace {

struct Level {
  int width = 0, height = 0;
  std::vector<float> value, weight;  // weight 1: known, 0: unknown
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
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

void push(const Level& coarse, Level& fine) {
  for (int y = 0; y < fine.height; ++y) {
    for (int x = 0; x < fine.width; ++x) {
      const std::size_t i = fine.at(x, y);
      if (fine.weight[i] >= 1) continue;
      const float around =
          bilinear(coarse, 0.5F * static_cast<float>(x) - 0.25F, 0.5F * static_cast<float>(y) - 0.25F);
      fine.value[i] = fine.weight[i] * fine.value[i] + (1 - fine.weight[i]) * around;
    }
  }
}

}  // namespace

void fill_unknown(int width, int height, int channels, const std::vector<bool>& known, float* values) {
  const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const auto step = static_cast<std::size_t>(channels);
  for (std::size_t c = 0; c < step; ++c) {
    std::vector<Level> levels(1);
    Level& base = levels.front();
    base.width = width;
    base.height = height;
    base.value.resize(size);
    base.weight.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
      base.value[i] = values[i * step + c];
      base.weight[i] = known[i] ? 1.F : 0.F;
    }
    while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(half(levels.back()));
    if (levels.back().weight[0] <= 0) levels.back().value[0] = 0;
    for (std::size_t l = levels.size() - 1; l-- > 0;) push(levels[l + 1], levels[l]);
    for (std::size_t i = 0; i < size; ++i) values[i * step + c] = levels[0].value[i];
  }
}

}  // namespace floatstage::render
