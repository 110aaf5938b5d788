#pragma once

#include "calib/calibrate.h"
#include "calib/observations.h"
#include "core/rig.h"
#include "tests/calib/synthetic_capture.h"

namespace floatstage::calib {

/// Stills, far apart in time.
inline const CaptureOptions kStills{.frames = 40, .frame_seconds = 0.2};

/// A board that keeps between two distances (m) from a camera, and turns and tilts there by so many degrees.
Path in_front(const RigCamera& camera, double nearest, double farthest, double tilt_degrees);

/// A capture with small reprojection errors that is worthless for that reason.
Observations failing_capture(CalibrationFailure kind);

}  // namespace floatstage::calib
