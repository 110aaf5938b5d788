#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/matte/label_correction.h"
#include "recon/label_volume.h"

namespace floatstage::pipeline {

/// Who a camera's mattes lack, and how that is known.
struct Lacks {
  int label = 0;               ///< 1 …
  int frame = 0;               ///< in which it came to light
  std::optional<int> said_of;  ///< a word said so, of this camera; none: label was carried there
  auto operator<=>(const Lacks&) const = default;
};

/// Cameras that are no witnesses of where somebody is: their mattes have nobody where most others show one
/// who is said, or expected, to be there.
using Disbelieved = std::map<int, Lacks>;

/// Who of the other cameras shows somebody at what most of a word's unmet pixels show, and who does not: at
/// the place along each ray that most cameras confirm, and of those the fewest deny. A camera without a
/// matte, or out of whose picture that is, says nothing. `mattes`: by camera, subject where >= 128.
struct OthersSay {
  std::vector<int> confirm, deny;
};
OthersSay ask_others(const Rig& rig, const std::vector<Image>& mattes, const NowhereWord& word);

/// The hull of an instant, of the cameras that are believed.
struct LabelHull {
  std::optional<recon::LabelVolume> volume;  ///< none where there is nobody, or silhouettes bound nothing
  std::string why;                           ///< the latter: why
  Disbelieved disbelieved;                   ///< without these
  std::vector<NowhereWord> nowhere;          ///< words that nobody in it can be meant by all the same
};

/// Where labels were in the instant before, as they are expected now, by label - 1: lattice coordinates.
using LabelPlaces = std::vector<std::vector<Eigen::Vector3i>>;

/// The same places with voxels of another edge.
LabelPlaces with_edge(const LabelPlaces& places, double edge, double other);

struct LabelHullOf {
  const Rig& rig;
  const std::vector<Image>& mattes;                    ///< by camera; empty where it has none
  int frame = 0;                                       ///< whose they are
  const std::map<int, LabelsAllowed>* said = nullptr;  ///< in this frame; null: nothing
  const Disbelieved& before;                           ///< in the instant beside
  const LabelPlaces& expected;
  int labels = 0, voxels = 0;  ///< voxels: in the box, about, of an instant that chooses their edge
  int threads = 0;             ///< 0: one per core
};

/// Cameras that have nobody at most of what the hull has near `places` of a label (by label - 1, lattice
/// coordinates), where at least twice as many show somebody there, as long as three cameras are left; and
/// those of `before` that still do. One of `before` that shows her again, or out of whose picture she is, is
/// believed. The hull need not have lost anything, since one camera in ten may deny what it keeps; of a label
/// of which it has lost half nothing is said.
Disbelieved who_lacks(const LabelHullOf& of, const recon::LabelVolume& volume, const LabelPlaces& places,
                      const Disbelieved& before);

/// Carves it: without cameras that were not believed before, and then with those of them that who_lacks()
/// believes again of where labels are expected, and without those that it does not any more. Where the hull
/// keeps less than half of where a label is expected, or a word has nothing of the hull in most of its
/// pixels, and at least twice as many cameras confirm it as deny it, those that deny are left out, as long as
/// three are left. `edge`: of voxels, metres; where it is 0 it is chosen. It is chosen anew where cameras are
/// left out and what the others bound then has more than twice `voxels`: it was chosen from a part of the
/// stage.
LabelHull label_hull(const LabelHullOf& of, double& edge);

}  // namespace floatstage::pipeline
