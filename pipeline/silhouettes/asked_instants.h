#pragma once

#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/silhouettes/left_out_hulls.h"

namespace floatstage::pipeline {

struct AskedInstants {
  std::vector<int> frames;
  std::vector<InstantMattes> mattes;  ///< of each
};

/// The mattes of two instants, a third of `frames` from either end, behind what stands on the stage
/// (load_occluders()). One that cannot be read is left out: the frame itself has failed, and says why.
Result<AskedInstants> asked_instants(const capture::TakeReader& take, const std::vector<int>& frames,
                                     int threads);

}  // namespace floatstage::pipeline
