#pragma once

#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"
#include "tests/support/matchers.h"

namespace floatstage::studio {

/// The embedded studio with `cameras` small cameras on a ring, and its shots.
class SyntheticShots {
 public:
  explicit SyntheticShots(int cameras = 1, int width = 320, int height = 240)
      : rig(synthetic_rig({.cameras = cameras, .width = width, .height = height})),
        studio(std::move(*SyntheticStudio::create(rig, {.samples = 4}))) {}

  const Rig rig;
  const SyntheticStudio studio;
};

}  // namespace floatstage::studio
