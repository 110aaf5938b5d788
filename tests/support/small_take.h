#pragma once

#include <gtest/gtest.h>

#include "pipeline/synthesize.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {

/// A small perfect synthetic take: 6 cameras, 160×120, in `folder`.
inline std::filesystem::path small_take(const TempFolder& folder, int frames = 2) {
  pipeline::SynthesizeOptions options;
  options.out = folder / "take";
  options.rig.cameras = 6;
  options.rig.width = 160;
  options.rig.height = 120;
  options.studio.samples = 4;
  options.frames = frames;
  EXPECT_THAT(pipeline::synthesize_take(options), IsOk());
  return options.out;
}

}  // namespace floatstage
