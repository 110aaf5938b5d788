#pragma once

#include <string>
#include <vector>

#include "core/measured.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/calibrate/session.h"

namespace floatstage::pipeline {

/// How well rays through the same points of the scene meet: a check of poses by pictures that the calibration
/// did not see.
struct ScenePoints {
  std::vector<Eigen::Vector3d> places;  ///< metres, where the rays come nearest to one another; one a point
  std::vector<Measured> camera_rms_px;  ///< one a camera of the rig
  Measured rms_px;                      ///< over all
};

/// NotFound names a camera that the rig lacks; BadData a point whose rays do not meet before the cameras.
Result<ScenePoints> measure_points(const std::vector<SessionPoint>& points, const Rig& rig);

/// "4 points of the scene meet within 9.9 px in the known rig (cam01 13.1, …)"
std::string describe(const ScenePoints& measured, const Rig& rig, const std::string& which);

}  // namespace floatstage::pipeline
