#pragma once

#include <cstring>
#include <utility>

#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"

namespace floatstage {

/// Pictures small enough for quick tests; the performer is about 100 px tall.
inline Rig small_rig(int cameras = 4) {
  return synthetic_rig({.cameras = cameras, .width = 160, .height = 120});
}

inline SyntheticStudioOptions quick_options(Defects defects = {}) {
  return {.seed = 7, .samples = 9, .defects = defects};
}

inline SyntheticStudio studio_with(const Rig& rig, const SyntheticStudioOptions& options) {
  Result<SyntheticStudio> studio = SyntheticStudio::create(rig, options);
  if (!studio) ADD_FAILURE() << studio.error().message;
  return std::move(studio).value();
}

/// Everything a shot says, bit by bit.
inline bool same_shot(const SyntheticShot& a, const SyntheticShot& b) {
  if (!(a.frame.info == b.frame.info) || !(a.frame.layout == b.frame.layout) ||
      a.frame.empty() != b.frame.empty())
    return false;
  if (!a.frame.empty() &&
      std::memcmp(a.frame.pixels.get(), b.frame.pixels.get(), a.frame.layout.size_bytes) != 0)
    return false;
  if (a.matte.empty() != b.matte.empty()) return false;
  if (!a.matte.empty() && !(to_image(a.matte) == to_image(b.matte))) return false;
  return a.depth == b.depth;
}

inline Image rgb_of(const SyntheticShot& shot) { return to_rgb(shot.frame).value(); }

}  // namespace floatstage
