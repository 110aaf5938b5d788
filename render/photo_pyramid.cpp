#include "render/photo_pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "render/mitchell.h"

namespace floatstage::render {
namespace {

constexpr float kWidestSharp = 2;  // px

// The mean of four pixels by their opacity; that of four that nothing is seen of, of their colours.
void mix_four(const std::array<const std::uint8_t*, 4>& four, std::uint8_t* to) {
  int plain[3] = {0, 0, 0}, alpha = 0;
  for (const std::uint8_t* p : four) {
    for (int c = 0; c < 3; ++c) plain[c] += p[c];
    alpha += p[3];
  }
  to[3] = static_cast<std::uint8_t>((alpha + 2) / 4);
  if (alpha == 0 || alpha == 4 * 255) {  // most are: no product, and no division
    for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint8_t>((plain[c] + 2) / 4);
    return;
  }
  int sum[3] = {0, 0, 0};
  for (const std::uint8_t* p : four)
    for (int c = 0; c < 3; ++c) sum[c] += p[c] * p[3];
  for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint8_t>((sum[c] + alpha / 2) / alpha);
}

void halve(const SceneTile& tile, SceneTile& half) {
  half.resize((tile.width + 1) / 2, (tile.height + 1) / 2);
  for (int y = 0; y < half.height; ++y) {
    const std::uint8_t *above = tile.at(0, 2 * y), *below = tile.at(0, std::min(2 * y + 1, tile.height - 1));
    std::uint8_t* to = half.at(0, y);
    for (int x = 0; x < half.width; ++x, to += 4) {
      const std::ptrdiff_t left = 4 * (2 * x), right = 4 * std::min(2 * x + 1, tile.width - 1);
      mix_four({above + left, above + right, below + left, below + right}, to);
    }
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
