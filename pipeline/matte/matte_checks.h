#pragma once

#include "capture/take.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::pipeline {

/// Adds to the report of every camera how its mattes flicker and how they agree with the hull of the others
/// (`options.hull_frames` instants, spread over the frames that were asked for), and a doubt where they
/// contradict one another. Errors: those of hull_agreement() and contradiction_in().
Result<void> check_mattes(capture::TakeReader& take, const MatteTakeOptions& options, MatteReport& report);

}  // namespace floatstage::pipeline
