#pragma once

#include <cstdlib>

#include <gtest/gtest.h>

#include "core/text.h"
#include "pipeline/process/process.h"
#include "pipeline/synthesize.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {

struct TakeSize {
  int cameras = 6, frames = 2, width = 160, height = 120;
  double lens_k1 = 0;
};

/// A synthetic take with mattes and meshes, in `folder`.
inline std::filesystem::path processed_take(const TempFolder& folder, const TakeSize& size = {}) {
  SynthesizeOptions options;
  options.out = folder / "take";
  options.rig.cameras = size.cameras;
  options.rig.width = size.width;
  options.rig.height = size.height;
  options.studio.samples = 4;
  options.studio.defects.lens_k1 = size.lens_k1;
  options.frames = size.frames;
  EXPECT_THAT(synthesize_take(options), IsOk());
  EXPECT_THAT(process_take({.take = options.out, .matte = "chroma", .hull = recon::HullOptions{}}), IsOk());
  return options.out;
}

/// The exit code of another program, whose words go to `log`.
inline int run_other(const std::string& command, const std::filesystem::path& log) {
  const int status =
      std::system(text("QT_QPA_PLATFORM=offscreen ", command, " >>'", log.string(), "' 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace floatstage::pipeline
