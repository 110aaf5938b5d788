#pragma once

#include <filesystem>
#include <vector>

#include "calib/markerless.h"
#include "core/rig.h"

namespace floatstage::calib {

/// Middlebury's temple, its cameras and lens as they are published.
struct TempleScene {
  Rig truth;
  std::vector<MarkerlessPicture> pictures;
};

/// Of the pictures in `folder` that `par` (templeR_par.txt) tells of, those that are there.
TempleScene temple_scene(const std::filesystem::path& folder, const char* par);

/// How far camera centres are off after the best similarity, percent of the rig's radius.
struct CenterErrors {
  double mean = 0, rms = 0, worst = 0;
};
CenterErrors center_errors(const Rig& rig, const Rig& truth);

}  // namespace floatstage::calib
