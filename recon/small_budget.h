#pragma once

#include <span>

#include "core/matte.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"
#include "recon/visual_hull.h"

// Private to the stage.
namespace floatstage::recon {

/// For hulls that clean-up could not bring down to MeshCleanup::triangles, or only at the cost of a twentieth
/// of a silhouette's IoU: decimation keeps handles, a surface of g handles has more than 4 g triangles, and
/// every loop of hair is one. The hull of simpler silhouettes takes their place, in which holes and strands
/// narrower than 4, 8, 16 … px are gone, with the least simplification whose mesh fits; not where it loses
/// more. `raw`: the hull before clean-up, with which the report's losses compare. `report` stays as it is
/// where nothing fits. Errors: those of visual_hull().
Result<void> meet_budget(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                         const Mesh& raw, HullReport& report);

}  // namespace floatstage::recon
