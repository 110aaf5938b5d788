#include "tests/calib/solver/solver_scenes.h"

#include <algorithm>

namespace floatstage::calib::solver {

TrueScene true_scene(int cameras, const CaptureOptions& options) {
  TrueScene s{.truth = ring_rig(cameras), .seen = {}, .scene = {}};
  const Target board = two_sided_board(7, 5, 0.09, 0.005);
  const Path path = wandering(options);
  s.seen = capture(s.truth, board, path, options);
  s.scene = make_scene(s.seen);
  for (std::size_t c = 0; c < s.scene.cameras.size(); ++c) {
    SceneCamera& camera = s.scene.cameras[c];
    camera.intrinsics = camera.start = pack(s.truth.cameras[c].model);
    camera.cam_from_world = s.truth.cameras[c].cam_from_world;
    camera.has_intrinsics = camera.placed = true;
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const TargetPoint& p : board.points) middle += p.position / static_cast<double>(board.points.size());
  for (SceneBoard& b : s.scene.boards) {
    b.world_from_target = path(b.frame * options.frame_seconds);
    b.world_from_target.translation -= b.world_from_target.rotation * middle;
    b.placed = true;
  }
  s.scene.reference = 0;
  return s;
}

double largest_error(const Scene& scene) {
  double largest = 0;
  for (const SceneView& v : scene.views)
    if (usable(scene, v))
      for (const Eigen::Vector2d& e : errors_of(scene, v)) largest = std::max(largest, e.norm());
  return largest;
}

}  // namespace floatstage::calib::solver
