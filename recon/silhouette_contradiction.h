#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/matte.h"
#include "core/rig.h"
#include "recon/silhouette_agreement.h"
#include "recon/visual_hull.h"

namespace floatstage::recon {

/// What is denied of each matte by the hull of all, where that hull may_contradict(); else nothing, at no
/// cost. `hull`: what `options` made of these mattes, with its quality. The shares are those of the exact
/// hull, whatever method and clean-up were asked for. That hull is within every matte that it denies
/// something of, so what it denies is what the hull of the others denies; but for a hull that is cut at the
/// end of what cameras see, where each camera's others are carved.
std::vector<SilhouetteAgreement> denials_of(const Rig& rig, const std::vector<Matte>& mattes,
                                            const HullReport& hull, const HullOptions& options, int frame);

/// Mattes that contradict one another. Which of them are wrong is not told by that: one that shows nobody
/// denies all others.
struct SilhouetteContradiction {
  enum class Denied {
    Most,       ///< most of the subject
    Twentieth,  ///< more than that
    Pieces,     ///< more than most_in_pieces(), as where each key lacks another part of the subject
  };
  Denied what = Denied::Most;
  int frames = 0;                        ///< in which half of the cameras are denied so much
  int worst = 0;                         ///< the frame where most are
  std::map<std::string, double> shares;  ///< there, of those cameras' mattes, by serial
};

/// Nothing unless so much is denied in at least half of a frame's cameras, two at least. What is worse is
/// said alone. The frames are those of `checked`, in any order.
std::optional<SilhouetteContradiction> contradiction_between(const std::vector<SilhouetteAgreement>& checked);

/// For people. `hint`: what a key may have mistaken, in brackets after a space, or nothing.
std::string describe(const SilhouetteContradiction& contradiction, const std::string& hint);

}  // namespace floatstage::recon
