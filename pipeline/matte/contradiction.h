#pragma once

#include <optional>
#include <set>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/matte/hull_agreement.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::pipeline {

/// Whether mattes that were checked contradict one another: in at least half of a frame's cameras most of the
/// subject lies outside the hull of the others, or, where that is nowhere, more than a twentieth of it
/// (SilhouetteAgreement::denied), or pieces of it (SilhouetteAgreement::pieces, most_in_pieces()), as where
/// keys lack what wears the cloth's colour and each camera lacks another part. Which of them are wrong is not
/// told by that: one that shows nobody denies all others. Named are the cameras that are denied, in the frame
/// where most are, with their picture in mattes/doubts, which is drawn anew with `draw`, else where it is not
/// there. Nothing where no frame does. Errors: those of writing the picture.
Result<std::optional<MatteDoubt>> contradiction_in(capture::TakeReader& take,
                                                   const std::vector<SilhouetteAgreement>& checked,
                                                   bool draw = true);

/// Removes the pictures that contradiction_in() drew before of these frames, but for that of what it says
/// now. Io.
Result<void> keep_denials(const TakeLayout& layout, const std::optional<MatteDoubt>& said,
                          const std::set<int>& frames);

/// Puts it first. What consistent matting said of the same cameras, that the others deny them, goes: it is
/// the same fault.
void add_contradiction(MatteDoubt contradiction, std::vector<MatteDoubt>& doubts);

}  // namespace floatstage::pipeline
