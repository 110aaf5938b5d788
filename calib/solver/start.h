#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/solver/scene.h"
#include "calib/solver/view_pose.h"
#include "core/result.h"

namespace floatstage::calib::solver {

/// A start for everything, found directly and without chance: focal lengths by trying them, views by
/// homographies, cameras along the tree of pairs that share most points, boards where most of their views
/// agree, markers by intersecting rays.

/// What two cameras saw together.
struct CameraPair {
  int a = 0, b = 0;
  int frames = 0, points = 0;
  bool in_tree = false;  ///< the start went along it
};

/// Of every board view with enough points: where the board is in its camera's frame (index as in
/// Scene::views).
using ViewPoses = std::vector<std::optional<ViewPose>>;

/// Points of a board view as positions and pixels, outliers left out.
std::vector<Correspondence> correspondences(const Scene& scene, const SceneView& view);

/// Intrinsics of one camera from its board views alone. BadData names the camera when it has none that could
/// serve.
Result<void> start_intrinsics(Scene& scene, int camera);

/// Places cameras, boards and markers. BadData names the cameras that no chain of targets joins to the
/// others.
Result<std::vector<CameraPair>> start_poses(Scene& scene, int threads);

/// Places the boards that are not placed yet, from the cameras that are.
void place_boards(Scene& scene, const ViewPoses& poses);

/// Places markers seen by two cameras that are placed; those that are not seen so leave the scene.
void place_markers(Scene& scene);

}  // namespace floatstage::calib::solver
