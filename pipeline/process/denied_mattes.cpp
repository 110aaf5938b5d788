#include "pipeline/process/denied_mattes.h"

#include <nlohmann/json.hpp>

#include "pipeline/matte/hull_cover.h"
#include "recon/mesh/mesh_silhouettes.h"

namespace floatstage::pipeline {

using nlohmann::json;

json denied_json(const Rig& rig, const std::vector<Matte>& mattes, const recon::HullReport& hull,
                 const recon::HullOptions& options) {
  json shares = json::object();
  if (!may_contradict(hull)) return shares;
  const auto say = [&](const std::string& serial, double share, double pieces) {
    shares["denied"][serial] = share;
    shares["denied_pieces"][serial] = pieces;
  };
  if (hull.cut) {
    for (const SilhouetteAgreement& a : agreement_between(rig, mattes, 0)) say(a.serial, a.denied, a.pieces);
    return shares;
  }
  recon::HullOptions exact = options;
  exact.method = recon::HullMethod::Exact;
  exact.cleanup = {};
  exact.quality = false;
  const bool same = options.method == recon::HullMethod::Exact && !options.cleanup.wanted();
  recon::HullReport anew;
  if (!same)
    if (Result<recon::HullReport> made = recon::visual_hull(rig, mattes, exact)) anew = std::move(*made);
  const Mesh& mesh = same ? hull.mesh : anew.mesh;
  if (mesh.empty()) return shares;
  const recon::MeshSilhouettes silhouettes(mesh);
  for (std::size_t c = 0; c < mattes.size(); ++c)
    if (!mattes[c].empty() && coverage(mattes[c]) > 0) {
      const Matte seen = silhouettes.of(rig.cameras[c]);
      say(rig.cameras[c].serial, denied_share(mattes[c], seen), denied_pieces(mattes[c], seen));
    }
  return shares;
}

std::vector<SilhouetteAgreement> denials_in(const std::map<int, json>& frames) {
  std::vector<SilhouetteAgreement> found;
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
