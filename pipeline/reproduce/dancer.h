#pragma once

#include "core/result.h"
#include "core/synthetic/synthetic_studio.h"
#include "pipeline/reproduce/comparison.h"

namespace floatstage::pipeline {

struct DancerOptions {
  int cameras = 8;  ///< in a ring
  int views = 4;    ///< in the middle between neighbouring cameras, spread over the ring
  int width = 640, height = 480;
  int frame = 0;
  Defects defects;  ///< of the photographs and their calibration; the truth has none
  Progress* progress = nullptr;
};

/// The synthetic studio's dancer, photographed by cameras all around, on the exact hull of the true mattes as
/// the published calibration makes it. Errors of the studio and of visual_hull(); Cancelled.
Result<TestScene> dancer(const DancerOptions& options);

}  // namespace floatstage::pipeline
