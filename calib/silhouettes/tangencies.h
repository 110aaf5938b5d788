#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/rig.h"
#include "core/silhouette.h"

namespace floatstage::calib {

/// What all that follows asks of an outline: the convex hull of its rays, without the lens. In order around
/// the subject; z = 1 in the camera's frame.
struct ConvexOutline {
  std::vector<Eigen::Vector3d> rays;
  std::vector<char> cut;  ///< the picture's border is there: the subject may go on beyond
  bool empty() const { return rays.empty(); }
};

/// Empty for an outline without points. Islands of less than a fiftieth of the largest are specks and left
/// out.
ConvexOutline convex_outline(const CameraModel& model, const Silhouette& outline);

/// Where an outline ends, seen along the planes through the line between two cameras: its outermost epipolar
/// tangents. Where cameras, instants and outlines agree, both cameras' lie in one plane, which touches the
/// subject in a frontier point (Porrill and Pollard 1991; Cipolla, Åström and Giblin 1995).
struct Extremes {
  double angle[2] = {0, 0};  ///< of the plane, rad, the smallest and the largest
  int ray[2] = {-1, -1};     ///< -1: the border cuts the subject there
};

/// The pencil of planes through the centres of two cameras, numbered by angle from a plane through the
/// subject.
class PlanePencil {
 public:
  /// Nothing when the centres are one. `towards`: a ray (world) from a's centre to the subject.
  static std::optional<PlanePencil> through(const RigCamera& a, const RigCamera& b,
                                            const Eigen::Vector3d& towards);
  double angle_of(const Eigen::Vector3d& ray_in_world) const;
  /// How far the plane's angle moves (rad) when the ray moves by a pixel across it.
  double angle_per_pixel(const RigCamera& camera, const Eigen::Vector3d& ray) const;
  /// Nothing when the other camera's centre lies within the outline: no plane touches it then.
  std::optional<Extremes> extremes(const RigCamera& camera, const ConvexOutline& outline) const;

 private:
  Eigen::Vector3d base_, zero_, across_;
};

}  // namespace floatstage::calib
