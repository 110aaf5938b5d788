#pragma once

#include <vector>

#include "recon/exact/exact_hull.h"
#include "recon/exact/silhouette_cones.h"
#include "recon/hull_input.h"
#include "recon/mesh/mesh_shells.h"
#include "recon/silhouette_audit.h"
#include "recon/stage_volume.h"
#include "recon/visual_hull.h"

namespace floatstage::recon {

struct HullWorkspace::Impl {
  PolygonBounds polygons;  // of the outline that is checked
  ConeBuilder builder;
  SilhouetteCones cones;
  ExactHull engine;
  std::vector<ConeView> views;
  StageFinder finder;
  StageVolume stage;
  SilhouetteAudit audit;
  ShellFilter shells;
};

/// The exact method of visual_hull(), for inputs that were checked. Fills everything of `report` but
/// silhouette_iou. False when the engine could not close the surface: the caller has another method.
Result<bool> exact_visual_hull(const Rig& rig, HullInput& input, const HullOptions& options,
                               HullWorkspace::Impl& workspace, HullReport& report);

}  // namespace floatstage::recon
