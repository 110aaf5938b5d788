#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "render/footprint.h"
#include "render/scene_impl.h"

namespace floatstage::render {

/// A scene's photographs at a half, a quarter … of their size (Eq. 10.4): means of two by two pixels, colours
/// by their opacity. Odd sizes are rounded up, the last row and column repeated.
struct PhotoPyramid {
  static constexpr std::size_t kLevels = kLastLevel;  ///< level 0 are the photographs themselves

  /// A scene's, of these cameras (indices into scene.cameras) at least: made when first asked for and kept
  /// until the scene changes.
  static const PhotoPyramid& of(const Scene::Impl& scene, std::span<const int> cameras);

  std::uint64_t version = 0;
  std::vector<std::vector<SceneTile>> levels;  ///< [level - 1][camera], of the cameras that are `made`
  std::vector<bool> made;
  std::vector<std::size_t> missing;  ///< what of() makes; its memory
};

/// The level at which a filter `width` px wide is no wider than kWidestFilter (Eq. 10.4), and at most
/// kLevels.
inline constexpr float kWidestTaps = 64;
inline int pyramid_level(float width) {
  int level = 0;
  while (width > kWidestTaps && level < static_cast<int>(PhotoPyramid::kLevels)) {
    width *= 0.5F;
    ++level;
  }
  return level;
}

/// Filters of ch. 10: how they are laid along the line of disparity. render/gl/shaders/filtered.comp has the
/// same.
struct FilterLine {
  static constexpr int kFewTaps = 4;  ///< as many as a filter has that is wider than a pixel, at least
  int level = 0, taps = 1;
  bool sharp = true;  ///< photographs are read by the spline: the filter is narrower than two pixels
  float step_u = 0, step_v = 0;  ///< px of the photograph from tap to tap

  /// `du`, `dv`: from one end of the line of disparity to the other, px; it is the filter's sampling
  /// distance.
  FilterLine(float du, float dv);
  /// The place of a tap from the line's middle, in steps; and its weight.
  static float place(int tap, int taps) {
    return static_cast<float>(tap) + 0.5F - 0.5F * static_cast<float>(taps);
  }
  static float weight(int tap, int taps);
};

}  // namespace floatstage::render
