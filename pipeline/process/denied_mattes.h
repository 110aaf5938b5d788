#pragma once

#include <map>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/matte.h"
#include "core/rig.h"
#include "recon/silhouette_agreement.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// A frame's part of the mesh record: "denied" and "denied_pieces", {"<serial>": share}, of each matte that
/// recon::denials_of() tells of.
nlohmann::json denied_json(const Rig& rig, const std::vector<Matte>& mattes, const recon::HullReport& hull,
                           const recon::HullOptions& options);

/// What the record's frames say of it, for contradiction_in(). `frames`: MeshRecord::reports.
std::vector<recon::SilhouetteAgreement> denials_in(const std::map<int, nlohmann::json>& frames);

}  // namespace floatstage::pipeline
