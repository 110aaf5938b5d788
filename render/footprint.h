#pragma once

#include <algorithm>

#include <Eigen/Geometry>

#include "core/rig.h"
#include "core/view.h"

namespace floatstage::render {

// How much of a photograph a pixel of the view covers (M. Eisemann, Error-Concealed Image-Based Rendering,
// Eq. 9.4-9.7), and which levels of its pyramid are read for it. docs/algorithms/blending.md derives both;
// render/gl/shaders/footprint.glsl is the twin.

/// The last level of a PhotoPyramid; level 0 are the photographs.
inline constexpr int kLastLevel = 5;

/// Up to this square of its footprint a pixel reads a level alone: the spline between the pixels blurs, too.
inline constexpr float kSharpArea = 1.5F;

/// Two neighbouring levels and how they are mixed: `next` is the share of level + 1.
struct LevelMix {
  int level = 0;
  float next = 0;
};

/// Of a pixel whose footprint is `area` squared pixels of the photograph, by the shorter of its axes: means
/// of 2^l by 2^l pixels whose variance is that of a square of `area` / kSharpArea.
inline LevelMix level_mix(float area) {
  if (!(area > kSharpArea)) return {};
  area /= kSharpArea;
  int level = 0;
  while (area >= 4 && level < kLastLevel) {
    area *= 0.25F;
    ++level;
  }
  if (level == kLastLevel) return {level, 0};
  return {level, std::max(area - 1, 0.F) / 3};
}

/// The footprint that reads a level alone.
inline float area_of_level(int level) { return kSharpArea * static_cast<float>(1 << (2 * level)); }

/// The last level that any pixel of the view reads of this camera's photograph; 0: the photograph alone. A
/// bound over the box of what is drawn, by the distances and focal lengths alone.
int deepest_level(const RigCamera& camera, const View& view, const Eigen::AlignedBox3f& box);

}  // namespace floatstage::render
