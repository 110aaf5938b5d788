#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/matte/matte_job.h"
#include "pipeline/matte/matte_store.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::pipeline {

/// Whether `auto` had better make mattes by what all cameras say at once than by each camera's key: in the
/// mean of the cameras the hull of all keys denies a twentieth of what they tell (of a key that tells nobody,
/// all), and of what ConsistentMatting makes of the same instant, the middle one that all pictured, half as
/// much is denied; where keys have lost a quarter, less. Trusted or not: what is to be doubted is said later.
/// Where each camera's key is a plate that was shot it is asked always, and no more is enough if it is
/// trusted. A sentence for whoever reads the report; empty: no. The same whichever of the take's cameras and
/// frames are asked for; what a camera's record says of `auto` holds for the others. Not asked where a person
/// has a say (strokes, a guide, mattes put into the take), of fewer than four cameras, and when
/// `options.together` tells. `jobs` have been prepared or not. Errors: those of reading the take; Cancelled.
/// See docs/adr/0305-auto-asks-all-cameras.md.
Result<std::string> all_cameras_instead(capture::TakeReader& take, const MatteTakeOptions& options,
                                        const MatteStore& store, const MatteEdits& edits,
                                        const std::vector<MatteJob>& jobs);

}  // namespace floatstage::pipeline
