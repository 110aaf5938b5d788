#pragma once

#include <vector>

#include "capture/added_file.h"
#include "core/matte.h"
#include "core/result.h"
#include "core/rig.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// recon::visual_hull() of what lenses have seen: what lies behind bars that were added to pictures is as
/// unknown as what lies beside them, and does not carve. The report speaks of whole pictures. Errors: those
/// of visual_hull().
Result<void> hull_inside_bars(const Rig& rig, const std::vector<Matte>& mattes,
                              const capture::AddedFile& added, const recon::HullOptions& options,
                              recon::HullWorkspace& workspace, recon::HullReport& report);

}  // namespace floatstage::pipeline
