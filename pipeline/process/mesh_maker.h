#pragma once

#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/mesh_record.h"
#include "pipeline/process/process.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// The second half of process_take(): makes the meshes of these frames that are missing or were made from
/// something else, saves `record` with them, and fills in what `report` says of meshes. A bad frame is
/// reported and does not stop the others. Io; Cancelled.
Result<void> make_meshes(capture::TakeReader& take, const ProcessOptions& options,
                         const recon::HullOptions& hull, MeshRecord record, const std::vector<int>& frames,
                         ProcessReport& report);

}  // namespace floatstage::pipeline
