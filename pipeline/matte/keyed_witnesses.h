#pragma once

#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/matte/matte_take.h"
#include "recon/silhouette_agreement.h"

namespace floatstage::pipeline {

/// For mattes of so few cameras that no hull judges them: photographs of up to seven others of the same
/// instant are keyed as the first of `cameras` was, for this question alone, and all are compared. Nothing
/// where that one was not keyed by a keyer or a plate, or where too few others can be keyed so. Errors: those
/// of reading mattes.
Result<std::vector<recon::SilhouetteAgreement>> agreement_with_keyed(capture::TakeReader& take, int frame,
                                                                     const std::vector<CameraMattes>& cameras,
                                                                     int threads);

}  // namespace floatstage::pipeline
