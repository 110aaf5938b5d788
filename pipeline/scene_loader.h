#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "capture/take.h"
#include "core/result.h"
#include "core/view.h"
#include "pipeline/mesh_record.h"

namespace floatstage::pipeline {

/// The mattes of one instant, whoever made them; empty where there is none. `hashes`, where it is given, gets
/// those of the bytes that were read.
Result<std::vector<Matte>> load_mattes(const capture::TakeReader& take, int frame,
                                       MatteHashes* hashes = nullptr);

/// Photographs, mattes and mesh of one instant of a processed take. NotFound says which stage is missing and
/// how to run it: no mesh, or one that is older than a matte of its instant. Of cameras that were keyed
/// against a coloured cloth the cloth's cast is taken off the photographs when `suppress_spill` is set.
Result<SceneFrame> load_scene(capture::TakeReader& take, int frame, bool suppress_spill);

/// The take's rig with the colours that `calibrate color` found for it, where it did. BadData when those are
/// of other cameras.
Result<Rig> rig_with_colors(const capture::TakeReader& take);

/// The box around the performer over all processed frames (every mesh that exists), metres.
Result<Eigen::AlignedBox3d> subject_box(const capture::TakeReader& take);

}  // namespace floatstage::pipeline
