#pragma once

#include <vector>

#include "calib/calibrate.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// Cross-validation. The frames of what moves are dealt out in turn to `holdout_every` folds, so that each
/// fold is spread over the whole capture. For a fold everything is solved again without its frames (cameras,
/// noise, time offsets, which points are outliers); then the cameras stay as they are while the fold's boards
/// and markers are placed by what was seen of them. Folds are taken until enough frames have been predicted,
/// in small captures all. Returns each camera's RMS error over all predicted points, in px, or why there is
/// none: nothing was to be held out, too few frames, or none of a camera's.
std::vector<Measured> holdout_errors(const Scene& solved, const Observations& observations,
                                     const CalibrationOptions& options);

}  // namespace floatstage::calib::solver
