#pragma once

#include <map>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/matte.h"
#include "core/rig.h"
#include "pipeline/matte/hull_agreement.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// A frame's part of the mesh record: "denied" and "denied_pieces", {"<serial>": share} of each matte that
/// the hull of all denies (denied_share(), denied_pieces()), where that hull may_contradict(); else nothing,
/// at no cost. `hull`: what `options` made of these mattes. The shares are those of the exact hull, whatever
/// method and clean-up were asked for. That hull is within every matte that it denies something of, so what
/// it denies is what the hull of the others denies; but for a hull that is cut at the end of what cameras
/// see, where each camera's others are carved, as `matte` does.
nlohmann::json denied_json(const Rig& rig, const std::vector<Matte>& mattes, const recon::HullReport& hull,
                           const recon::HullOptions& options);

/// What the record's frames say of it, for contradiction_in(). `frames`: MeshRecord::reports.
std::vector<SilhouetteAgreement> denials_in(const std::map<int, nlohmann::json>& frames);

}  // namespace floatstage::pipeline
