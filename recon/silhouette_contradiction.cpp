#include "recon/silhouette_contradiction.h"

#include <cmath>

#include "core/statistics.h"
#include "core/text.h"
#include "recon/hull_cover.h"
#include "recon/mesh/mesh_silhouettes.h"

namespace floatstage::recon {
namespace {

using Denied = SilhouetteContradiction::Denied;

constexpr double kMost = 0.5;     // of a matte, and of the cameras: a majority
constexpr double kDenied = 0.05;  // of a matte, in most cameras: as kDeniedInMost of consistent_verdict.cpp

double denied_of(const SilhouetteAgreement& a, Denied what) {
  return what == Denied::Most ? a.surplus : what == Denied::Twentieth ? a.denied : a.pieces;
}

double most_of(Denied what, int cameras) {
  return what == Denied::Most ? kMost : what == Denied::Twentieth ? kDenied : most_in_pieces(cameras);
}

struct Vote {
  int cameras = 0;
  std::map<std::string, double> denied;
  bool contradicts() const {
    return static_cast<double>(denied.size()) >= kMost * cameras && denied.size() > 1;
  }
};

SilhouetteContradiction count(const std::vector<SilhouetteAgreement>& checked, Denied what) {
  std::map<int, Vote> votes;
  for (const SilhouetteAgreement& a : checked) ++votes[a.frame].cameras;
  for (const SilhouetteAgreement& a : checked) {
    Vote& vote = votes[a.frame];
    if (denied_of(a, what) > most_of(what, vote.cameras)) vote.denied[a.serial] = denied_of(a, what);
  }
  SilhouetteContradiction found{what, 0, 0, {}};
  for (auto& [frame, vote] : votes) {
    if (!vote.contradicts()) continue;
    ++found.frames;
    if (vote.denied.size() <= found.shares.size()) continue;
    found.worst = frame;
    found.shares = std::move(vote.denied);
  }
  return found;
}

}  // namespace

std::vector<SilhouetteAgreement> denials_of(const Rig& rig, const std::vector<Matte>& mattes,
                                            const HullReport& hull, const HullOptions& options, int frame) {
  std::vector<SilhouetteAgreement> found;
  if (!may_contradict(hull)) return found;
  if (hull.cut) return agreement_between(rig, mattes, frame);
  HullOptions exact = options;
  exact.method = HullMethod::Exact;
  exact.cleanup = {};
  exact.quality = false;
  const bool same = options.method == HullMethod::Exact && !options.cleanup.wanted();
  HullReport anew;
  if (!same)
    if (Result<HullReport> made = visual_hull(rig, mattes, exact)) anew = std::move(*made);
  const Mesh& mesh = same ? hull.mesh : anew.mesh;
  if (mesh.empty()) return found;
  const MeshSilhouettes silhouettes(mesh);
  for (std::size_t c = 0; c < mattes.size(); ++c)
    if (!mattes[c].empty() && coverage(mattes[c]) > 0)
      found.push_back(
          agreement_with(rig.cameras[c].serial, frame, mattes[c], silhouettes.of(rig.cameras[c])));
  return found;
}

std::optional<SilhouetteContradiction> contradiction_between(
    const std::vector<SilhouetteAgreement>& checked) {
  for (const Denied what : {Denied::Most, Denied::Twentieth, Denied::Pieces}) {
    SilhouetteContradiction found = count(checked, what);
    if (found.frames > 0) return found;
  }
  return std::nullopt;
}

std::string describe(const SilhouetteContradiction& contradiction, const std::string& hint) {
  if (contradiction.what == Denied::Most)
    return "the hull of the other cameras denies more than half of the subject, and so in half of the "
           "cameras: "
           "these mattes are wrong, or those of cameras that miss the subject";
  std::vector<double> shares;
  for (const auto& [serial, share] : contradiction.shares) shares.push_back(share);
  return text("the hull of all cameras denies ", std::lround(100 * median(std::move(shares))),
              " % of the subject",
              contradiction.what == Denied::Twentieth ? ", and more than a twentieth in half of the cameras"
                                                      : " in whole pieces, in half of the cameras",
              ": mattes lack what others show", hint, ", or the calibration is off");
}

}  // namespace floatstage::recon
