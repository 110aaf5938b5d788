#pragma once

#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/progress.h"
#include "recon/silhouette_agreement.h"

namespace floatstage::pipeline {

/// Carves, for each camera with a matte, the hull of all the others, and compares its silhouette with the
/// matte that it has not seen. A hull of few cameras is larger than the subject, so the figures tell cameras
/// and frames apart rather than being good or bad by themselves. A camera is left out where fewer than two
/// others have a matte with a subject. Sorted, least agreement first. Frames are carved in parallel; same
/// result at any number of threads.
Result<std::vector<recon::SilhouetteAgreement>> hull_agreement(const capture::TakeReader& take,
                                                               const std::vector<int>& frames, int threads,
                                                               Progress* watch = nullptr);

}  // namespace floatstage::pipeline
