#pragma once

#include <filesystem>

#include "capture/take.h"
#include "core/result.h"
#include "core/synthetic/synthetic_studio.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct SynthesizeOptions {
  std::filesystem::path out;
  SyntheticRigOptions rig;
  SyntheticStudioOptions studio;
  int frames = 24;
  bool depth = false;  ///< write the true depth too (large)
  capture::TakeWriterOptions take;
  Progress* progress = nullptr;  ///< null: unwatched
  int threads = 0;
};

/// Writes a take of the synthetic studio: the published rig, photographs, clean plates, and below truth/ the
/// true rig, mattes (of two performers also each one's, under the labels "first" and "second"), meshes and
/// (on request) depth as PFM (metres, infinity where there is no performer).
Result<void> synthesize_take(const SynthesizeOptions& options);

/// The rig of `options` with the lens defect built in: what SyntheticStudio::create wants.
Rig true_rig(const SynthesizeOptions& options);

}  // namespace floatstage::pipeline
