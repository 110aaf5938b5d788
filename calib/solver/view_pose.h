#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "calib/solver/projection.h"
#include "core/camera.h"

namespace floatstage::calib::solver {

/// A point of a target and the pixel where one camera saw it.
struct Correspondence {
  Eigen::Vector3d position;
  Eigen::Vector2d pixel;
};

struct ViewPose {
  Rigid3 cam_from_target;
  double error = 0;  ///< median pixel error
};

/// Where a target is in a camera's frame: directly from a homography (flat targets; at least 4 points) or a
/// projection matrix (6 points), then refined. Of the two tilts that a small flat board can have, the one
/// with the smaller error. A few wrong points do no harm. Absent when the points are too few or too nearly on
/// a line.
std::optional<ViewPose> view_pose(const Intrinsics& intrinsics, LensKind lens, int width, int height,
                                  const std::vector<Correspondence>& points);

/// Least squares with a robust loss from a pose nearby.
ViewPose refine_pose(const Intrinsics& intrinsics, LensKind lens, const std::vector<Correspondence>& points,
                     const Rigid3& start, int iterations = 20);

/// The homography from a flat target's own two axes to pixels, robust against a few wrong points, and its
/// median error in pixels. Infinite when there is none. Needs no intrinsics: what tells a wrong layout from a
/// wrong lens.
double homography_error(const std::vector<Correspondence>& points);

}  // namespace floatstage::calib::solver
