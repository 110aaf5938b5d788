#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "capture/take.h"
#include "core/result.h"
#include "core/view.h"

namespace floatstage::pipeline {

/// The mattes of one instant as `process` left them; empty where there is none.
Result<std::vector<Matte>> load_mattes(const capture::TakeReader& take, int frame);

/// Photographs, mattes and mesh of one instant of a processed take. NotFound says which stage is missing and
/// how to run it. When the take was keyed against a coloured cloth and `suppress_spill` is set, the cloth's
/// cast is taken off the photographs.
Result<SceneFrame> load_scene(capture::TakeReader& take, int frame, bool suppress_spill);

/// The take's rig with the colours that `calibrate color` found for it, where it did. BadData when those are
/// of other cameras.
Result<Rig> rig_with_colors(const capture::TakeReader& take);

/// The box around the performer over all processed frames (every mesh that exists), metres.
Result<Eigen::AlignedBox3d> subject_box(const capture::TakeReader& take);

}  // namespace floatstage::pipeline
