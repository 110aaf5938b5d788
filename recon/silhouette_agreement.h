#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/matte.h"
#include "core/rig.h"

namespace floatstage::recon {

/// One silhouette against what the other cameras say.
struct SilhouetteAgreement {
  std::string serial;
  int frame = 0;
  double iou = 0;      ///< of the matte with the silhouette of the hull of all other cameras
  double surplus = 0;  ///< share of the matte that lies outside that hull: what the others deny
  double denied = 0;   ///< likewise, without what outlines are off by: denied_share()
  double pieces = 0;   ///< of that, what is thick: denied_pieces()
};

/// Share of the matte that lies farther than two pixels outside of `hull`, a silhouette of the same size.
double denied_share(const Matte& matte, const Matte& hull);

/// Of that share, what is in pieces as thick as a twenty-fifth of a square of the matte's area: what is lost
/// of a body, where outlines and rigs that are off by some pixels leave strips.
double denied_pieces(const Matte& matte, const Matte& hull);

/// The silhouette, in a camera's picture, of the hull of all other mattes; absent where fewer than two others
/// show a subject or they bound no space.
std::optional<Matte> silhouette_of_others(const Rig& rig, const std::vector<Matte>& mattes,
                                          std::size_t camera);

/// A matte against `hull`, a silhouette of the same size.
SilhouetteAgreement agreement_with(const std::string& serial, int frame, const Matte& matte,
                                   const Matte& hull);

/// Of each camera with a matte, in the order of the rig, on one thread: carves the hull of all others,
/// and compares its silhouette with the matte that it has not seen. A camera is left out where fewer than two
/// others show a subject. `mattes`: one a camera of the rig, or empty.
std::vector<SilhouetteAgreement> agreement_between(const Rig& rig, const std::vector<Matte>& mattes,
                                                   int frame);

}  // namespace floatstage::recon
