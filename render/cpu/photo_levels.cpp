#include "render/cpu/photo_levels.h"

#include <algorithm>
#include <cmath>

#include "render/cpu/projection.h"

namespace floatstage::render::cpu {

void PhotoLevels::set(const PhotoCamera& photograph, const PhotoPyramid* pyramid, std::size_t camera) {
  levels_[0] = photograph;
  has_levels_ = pyramid != nullptr;
  for (std::size_t level = 1; has_levels_ && level < levels_.size(); ++level) {
    const SceneTile& tile = pyramid->levels[level - 1][camera];
    PhotoCamera& c = levels_[level] = photograph;
    c.tile_x = c.tile_y = 0;
    c.tile_width = static_cast<float>(tile.width);
    c.tile_height = static_cast<float>(tile.height);
    c.tile = tile.at(0, 0);
    c.tile_stride = tile.stride();
  }
}

void PhotoLevels::read(bool sharp, const float* u, const float* v, const float* area,
                       const std::int32_t* wanted, int count, float* rgba, RowMemory& memory) const {
  const auto n = static_cast<std::size_t>(count);
  float most = 0;
  for (std::size_t i = 0; has_levels_ && area != nullptr && i < n; ++i)
    if (wanted[i] != 0) most = std::max(most, area[i]);
  if (most <= kSharpArea) {
    read_colors(levels_[0], sharp, u, v, wanted, count, rgba);
    return;
  }
  const std::size_t mark = memory.used();
  float *mix = memory.floats(n), *lu = memory.floats(n), *lv = memory.floats(n), *read = memory.floats(4 * n);
  std::int32_t *level = memory.ints(n), *now = memory.ints(n);
  std::array<bool, kLastLevel + 2> needed{};
  for (std::size_t i = 0; i < n; ++i) {
    if (wanted[i] == 0) continue;
    const LevelMix m = level_mix(area[i]);
    mix[i] = m.next;
    level[i] = m.level;
    needed[static_cast<std::size_t>(m.level)] = true;
    if (m.next > 0) needed[static_cast<std::size_t>(m.level) + 1] = true;
    std::fill_n(rgba + 4 * i, 4, 0.F);
  }
  for (int l = 0; l <= kLastLevel; ++l) {
    if (!needed[static_cast<std::size_t>(l)]) continue;
    const float shrink = std::ldexp(1.F, -l);
    const float off_x = l > 0 ? levels_[0].tile_x : 0, off_y = l > 0 ? levels_[0].tile_y : 0;
    for (std::size_t i = 0; i < n; ++i) {
      now[i] = wanted[i] != 0 && (level[i] == l || (level[i] + 1 == l && mix[i] > 0)) ? 1 : 0;
      lu[i] = shrink * (u[i] - off_x);
      lv[i] = shrink * (v[i] - off_y);
    }
    read_colors(levels_[static_cast<std::size_t>(l)], sharp, lu, lv, now, count, read);
    for (std::size_t i = 0; i < n; ++i) {
      if (now[i] == 0) continue;
      const float share = level[i] == l ? 1 - mix[i] : mix[i];
      for (std::size_t c = 0; c < 4; ++c) rgba[4 * i + c] += share * read[4 * i + c];
    }
  }
  memory.take_back(mark);
}

}  // namespace floatstage::render::cpu
