#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/result.h"
#include "core/rig.h"

namespace floatstage::recon {

/// What the cameras of a rig look at together.
struct SharedView {
  Eigen::Vector3d fixation;  ///< metres, world: nearest to all optical axes (core/rig.h, focus_point)
  double radius = 0;         ///< metres: of the largest ball around it that `seen_by` cameras see whole
  Eigen::AlignedBox3d box;   ///< around all that at least `seen_by` cameras see, within their own distance
  int seen_by = 0;           ///< cameras that were asked to agree
  std::vector<int> astray;   ///< cameras whose pictures do not show the fixation
};

/// Finds it by asking a grid of points, so to a fortieth of the cameras' distance. `share` of the cameras (at
/// least two of them, rounded up) have to see a point. What is nearer to a camera than a tenth of its
/// distance to the fixation is not looked at. Parallel cameras have no fixation: it is then where core/rig.h
/// says. Errors: those of check(rig); InvalidArgument for a rig of one camera or a share outside 0 … 1;
/// BadData when there is no space that so many cameras see.
Result<SharedView> shared_view(const Rig& rig, double share = 0.75);

}  // namespace floatstage::recon
