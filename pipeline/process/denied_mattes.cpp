#include "pipeline/process/denied_mattes.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "recon/mesh/mesh_mask.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

constexpr double kOpen = 0.05;  // of a silhouette: less cannot hold what contradiction_in() asks for

bool leaves_much_open(const recon::HullReport& hull) {
  int known = 0, open = 0;
  for (std::size_t c = 0; c < hull.silhouette_iou.size(); ++c) {
    if (std::isnan(hull.silhouette_iou[c])) continue;
    const double by_cleanup = hull.cleanup ? hull.cleanup->iou_loss[c] : 0;
    ++known, open += 1 - hull.silhouette_iou[c] - by_cleanup > kOpen;
  }
  return known > 0 && 2 * open >= known;
}

}  // namespace

json denied_json(const Rig& rig, const std::vector<Matte>& mattes, const recon::HullReport& hull,
                 const recon::HullOptions& options) {
  json shares = json::object();
  if (!leaves_much_open(hull)) return shares;
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
  for (std::size_t c = 0; c < mattes.size(); ++c)
    if (!mattes[c].empty() && coverage(mattes[c]) > 0)
      shares[rig.cameras[c].serial] = denied_share(mattes[c], recon::mesh_mask(rig.cameras[c], mesh));
  return shares;
}

std::vector<SilhouetteAgreement> denials_in(const std::map<int, json>& frames) {
  std::vector<SilhouetteAgreement> found;
  for (const auto& [frame, report] : frames) {
    const json shares = report.is_object() ? report.value("denied", json::object()) : json::object();
    for (const auto& [serial, share] : shares.items())
      if (share.is_number()) found.push_back({serial, frame, 1 - share.get<double>(), share, share});
  }
  return found;
}

}  // namespace floatstage::pipeline
