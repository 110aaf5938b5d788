#pragma once

#include <vector>

#include "calib/calibrate.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// Before solving: boards whose points fit no plane picture as they are laid out, but do with rows and
/// columns exchanged.
std::vector<NamedFailure> wrong_layouts(const Scene& scene);

/// Of a solution: depth, tilt, lengths and faces.
std::vector<NamedFailure> weak_geometry(const Scene& scene, const std::vector<CameraQuality>& cameras,
                                        const std::vector<LengthQuality>& lengths,
                                        const CalibrationOptions& options);

/// Cameras whose pictures fit another instant, found by solving again for time offsets where the errors
/// follow the motion.
std::vector<NamedFailure> late_cameras(const Scene& scene, const CalibrationOptions& options);

}  // namespace floatstage::calib::solver
