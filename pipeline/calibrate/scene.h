#pragma once

#include "pipeline/calibrate/session_observations.h"

namespace floatstage::pipeline {

/// Places the cameras of a session by what they see of the scene (COLMAP, in `workspace`: a new folder) and
/// adds the points they share to what is solved for. Known poses that are fixed or a start are kept as the
/// start; where a camera has moved too far for that, all are placed anew and brought back onto the known
/// ones. Needs known intrinsics and something that gives the scale.
Result<void> add_scene(const Session& session, const std::filesystem::path& workspace, int threads,
                       const Progress* watch, SessionObservations& collected);

}  // namespace floatstage::pipeline
