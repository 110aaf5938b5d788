#pragma once

#include <optional>
#include <span>
#include <string>

#include "calib/markerless.h"
#include "calib/observations.h"
#include "core/measured.h"

namespace floatstage::calib {

/// Adds points of the scene to what the solver is given: each is a static marker of its own. picture i is of
/// camera camera_of_picture[i]; one picture a camera. Those that most cameras see come first, `most` at most;
/// a point all of whose cameras have their share of 60,000 sights already (200 at least) is left out.
/// `sigma`: px, what features are good for.
void add_features(Observations& observations, std::span<const SceneFeature> features,
                  std::span<const int> camera_of_picture, std::size_t most = 4000, double sigma = 0.5);

/// How many metres a unit of the rig is, from what its cameras see of boards and wands in the same frames
/// (camera i of the rig is camera i of the observations): the median over known lengths. Absent when fewer
/// than three lengths are seen by two cameras.
std::optional<double> metres_per_unit(const Observations& observations, const Rig& rig);

/// The rig moved, turned and scaled onto the known one, by serial: most cameras have not moved, those that
/// have do not matter (medians and consensus). Absent when fewer than three cameras are in both.
std::optional<Rig> onto_known(const Rig& rig, const Rig& known);

/// How far cameras are from known places after the best similarity (Umeyama 1991); percentages of the known
/// rig's mean distance from what it looks at.
struct RigAgreement {
  int cameras = 0;
  double rms_percent = 0, worst_percent = 0;
  Measured worst_turn_degrees;  ///< not of centres in one line: a turn about it is anyone's guess
  double scale = 1;             ///< known over solved
  std::string worst;            ///< serial
};
/// BadData says why rigs cannot be compared: fewer than three cameras are in both (a similarity fits any two
/// centres exactly), or the centres of either stand in one point.
Result<RigAgreement> agreement(const Rig& rig, const Rig& known);

}  // namespace floatstage::calib
