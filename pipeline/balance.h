#pragma once

#include "capture/take.h"
#include "core/result.h"
#include "core/view.h"

namespace floatstage::pipeline {

/// `rig` with gains that make its cameras agree on the surface of `scene`, as its photographs show it: three
/// a camera, the mean of all as it was. Cameras without a photograph or a matte take no part. A rig with
/// colours of its own (`calibrate color`) is left as it is. Errors: a photograph's.
Result<Rig> balanced(Rig rig, const SceneFrame& scene);

/// The take's rig with the colours that `calibrate color` found, else balanced
/// on the first frame that has a subject. Always the same for a take, whatever is drawn of it.
Result<Rig> rig_in_balance(capture::TakeReader& take);

}  // namespace floatstage::pipeline
