#include "pipeline/process/denied_mattes.h"

#include <nlohmann/json.hpp>

#include "recon/silhouette_contradiction.h"

namespace floatstage::pipeline {

using nlohmann::json;

json denied_json(const Rig& rig, const std::vector<Matte>& mattes, const recon::HullReport& hull,
                 const recon::HullOptions& options) {
  json shares = json::object();
  for (const recon::SilhouetteAgreement& a : recon::denials_of(rig, mattes, hull, options, 0)) {
    shares["denied"][a.serial] = a.denied;
    shares["denied_pieces"][a.serial] = a.pieces;
  }
  return shares;
}

std::vector<recon::SilhouetteAgreement> denials_in(const std::map<int, json>& frames) {
  std::vector<recon::SilhouetteAgreement> found;
  for (const auto& [frame, report] : frames) {
    const json shares = report.is_object() ? report.value("denied", json::object()) : json::object(),
               pieces = report.is_object() ? report.value("denied_pieces", json::object()) : json::object();
    for (const auto& [serial, share] : shares.items())
      if (share.is_number())
        found.push_back(
            {serial, frame, 1 - share.get<double>(), share, share, pieces.value(serial, json(0.0))});
  }
  return found;
}

}  // namespace floatstage::pipeline
