#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/matte.h"
#include "core/silhouette.h"

namespace floatstage::calib {

/// A camera at one instant: what it saw, and what all others leave of space, seen by it.
struct SilhouetteWitness {
  Silhouette own;  ///< px of the camera's pictures
  /// The silhouette of the others' visual hull, in a picture `scale` times as large in both directions: 255
  /// inside, 0 outside.
  Matte others;
  int scale = 1;
};

/// How a camera would have to turn for its silhouettes to lie within what the others leave.
struct SilhouetteTurn {
  bool known = false;  ///< outlines that constrain all three angles, in pictures that are alike
  double degrees = 0;  ///< angle of the turn
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();  ///< rad, camera frame: cam_from_world becomes
                                                     ///< rotation(vector) * cam_from_world
  double sigma_degrees = 0;  ///< standard deviation of the angle, from stretches of the outlines left out
  int points = 0;            ///< of outlines
  /// Root mean square of how far points lie outside of what the others leave (0 for those inside; farther
  /// than kFarthest counts as that), px, as the camera stands and after the turn.
  double outside_px = 0, outside_after_px = 0;
  /// Share of the points that lie farther outside than a small turn explains, after it: the mattes are wrong.
  double gross = 0;
};

/// A point farther outside than this (px) is no matter of a small turn.
inline constexpr double kFarthestOutside = 12;

/// The coherence of a camera's silhouettes with the others' (Hernández, Schmitt and Cipolla 2007): every ray
/// along an outline must meet the body that the others leave. What sticks out is made small over all
/// instants at once, by a turn of the camera about its centre; what lies inside is free, since a hull of few
/// cameras is larger than its body. Outlines along the picture's border are left out. Of
/// each outline about `points` are asked, evenly spread, or all. Deterministic.
SilhouetteTurn measure_silhouette_turn(const CameraModel& model, std::span<const SilhouetteWitness> witnesses,
                                       std::optional<std::size_t> points = {});

/// The camera's pose after it.
Rigid3 turned(const Rigid3& cam_from_world, const Eigen::Vector3d& vector);

}  // namespace floatstage::calib
