#include "render/photo_pyramid.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "render/mitchell.h"

namespace floatstage::render {
namespace {

constexpr float kWidestSharp = 2;  // px

void halve(const SceneTile& tile, SceneTile& half) {
  half.resize((tile.width + 1) / 2, (tile.height + 1) / 2);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x) {
      int sum[3] = {0, 0, 0}, plain[3] = {0, 0, 0}, alpha = 0;
      for (int k = 0; k < 4; ++k) {
        const std::uint8_t* p =
            tile.at(std::min(2 * x + (k & 1), tile.width - 1), std::min(2 * y + (k >> 1), tile.height - 1));
        for (int c = 0; c < 3; ++c) sum[c] += p[c] * p[3], plain[c] += p[c];
        alpha += p[3];
      }
      std::uint8_t* to = half.at(x, y);
      for (int c = 0; c < 3; ++c)
        to[c] = static_cast<std::uint8_t>(alpha > 0 ? (sum[c] + alpha / 2) / alpha : (plain[c] + 2) / 4);
      to[3] = static_cast<std::uint8_t>((alpha + 2) / 4);
    }
  half.repeat_border();
}

}  // namespace

const PhotoPyramid& PhotoPyramid::of(const Scene::Impl& scene, std::span<const int> cameras) {
  if (!scene.pyramid) scene.pyramid = std::make_shared<PhotoPyramid>();
  auto* kept = static_cast<PhotoPyramid*>(scene.pyramid.get());
  if (kept->version != scene.version) {
    kept->levels.resize(kLevels);
    for (std::vector<SceneTile>& level : kept->levels)
      level.resize(std::max(level.size(), scene.cameras.size()));
    kept->made.assign(scene.cameras.size(), false);
    kept->version = scene.version;
  }
  std::vector<std::size_t>& missing = kept->missing;
  missing.clear();
  for (int camera : cameras) {
    const auto i = static_cast<std::size_t>(camera);
    if (kept->made[i]) continue;
    kept->made[i] = true;
    missing.push_back(i);
  }
  parallel_for(missing.size(), 0, [&](std::size_t i) {
    const std::size_t camera = missing[i];
    for (std::size_t level = 0; level < kLevels; ++level)
      halve(level == 0 ? scene.tiles[camera] : kept->levels[level - 1][camera], kept->levels[level][camera]);
  });
  return *kept;
}

FilterLine::FilterLine(float du, float dv) {
  const float distance = std::hypot(du, dv), width = 2 * kMitchellReach * distance;
  level = pyramid_level(width);
  const float shrink = std::ldexp(1.F, -level);
  const int few = std::clamp(static_cast<int>(std::ceil(kFewTaps * width)), 1, kFewTaps);
  taps = std::clamp(static_cast<int>(std::ceil(width * shrink)), few, static_cast<int>(kWidestTaps));
  sharp = width <= kWidestSharp;
  const float share = 2 * kMitchellReach / static_cast<float>(taps);
  step_u = share * du;
  step_v = share * dv;
}

float FilterLine::weight(int tap, int taps) {
  return mitchell(2 * kMitchellReach * place(tap, taps) / static_cast<float>(taps));
}

}  // namespace floatstage::render
