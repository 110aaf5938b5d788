#pragma once

#include <optional>
#include <set>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/matte/matte_take.h"
#include "recon/silhouette_agreement.h"

namespace floatstage::pipeline {

/// What recon::contradiction_between() finds in mattes that were checked, as a doubt. Named are the cameras
/// that are denied, in the frame where most are, with their picture in mattes/doubts, which is drawn anew
/// with `draw`, else where it is not there. Nothing where no frame does. Errors: those of writing the
/// picture.
Result<std::optional<MatteDoubt>> contradiction_in(capture::TakeReader& take,
                                                   const std::vector<recon::SilhouetteAgreement>& checked,
                                                   bool draw = true);

/// Removes the pictures that contradiction_in() drew before of these frames, but for that of what it says
/// now. Io.
Result<void> keep_denials(const TakeLayout& layout, const std::optional<MatteDoubt>& said,
                          const std::set<int>& frames);

/// Puts it first. What consistent matting said of the same cameras, that the others deny them, goes: it is
/// the same fault.
void add_contradiction(MatteDoubt contradiction, std::vector<MatteDoubt>& doubts);

}  // namespace floatstage::pipeline
