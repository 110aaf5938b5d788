#pragma once

#include <span>

#include "recon/visual_hull.h"

namespace floatstage::recon {

/// Does to `report.mesh` what options.cleanup asks for and fills report.cleanup; sources, volume and remarks
/// follow. The result is checked: a mesh that did not stay closed, manifold and oriented is put back as it
/// was, with a remark. mattes[i] belongs to rig.cameras[i]; only views with a matte bind the vertices.
void clean_up_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                   HullReport& report);

}  // namespace floatstage::recon
