#include "tests/calib/failing_captures.h"

#include <cmath>
#include <numbers>

namespace floatstage::calib {

Path in_front(const RigCamera& camera, double nearest, double farthest, double tilt_degrees) {
  const Rigid3 world_from_cam = camera.cam_from_world.inverse();
  return [=](double t) {
    const double distance = nearest + (farthest - nearest) * (0.5 + 0.5 * std::sin(1.3 * t)),
                 tilt = tilt_degrees * std::numbers::pi / 180;
    const Eigen::Vector3d place(0.25 * distance * std::sin(1.1 * t), 0.2 * distance * std::sin(1.7 * t),
                                distance);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(tilt * std::sin(2.3 * t), Eigen::Vector3d::UnitX()) *
                                  Eigen::AngleAxisd(tilt * std::cos(2.9 * t), Eigen::Vector3d::UnitY()));
    return world_from_cam * Rigid3{turn, place};
  };
}

Observations failing_capture(CalibrationFailure kind) {
  const Rig alone = ring_rig(1), four = ring_rig(4);
  const Target board = grid_board(7, 5, 0.06), two_sided = two_sided_board(7, 5, 0.08, 0.005);
  const Path sound = in_front(alone.cameras[0], 1.2, 2.5, 35);
  switch (kind) {
    case CalibrationFailure::ConstantDepth:
      return capture(alone, grid_board(7, 5, 0.04), in_front(alone.cameras[0], 2, 2.05, 15), kStills);
    case CalibrationFailure::PlanarMotion:
      return capture(alone, board, in_front(alone.cameras[0], 1.2, 2.5, 0), kStills);
    case CalibrationFailure::SwappedRowsColumns: {
      Observations seen = capture(alone, board, sound, kStills);
      seen.targets[0] = grid_board(5, 7, 0.06);
      return seen;
    }
    case CalibrationFailure::WrongSquareSize: {
      const CaptureOptions options{.frames = 60, .frame_seconds = 0.2};
      Observations seen = capture(four, two_sided, wandering(options), options);
      capture_more(seen, four, wand({0, 0.3, 0.7}, 2e-4), wandering(options), options);
      seen.targets[0] = two_sided_board(7, 5, 0.084, 0.005);  // it was printed smaller than is believed
      return seen;
    }
    case CalibrationFailure::MirroredBoard: {
      Observations seen = capture(alone, board, sound, kStills);
      for (TargetPoint& p : seen.targets[0].points) p.position.x() *= -1;
      return seen;
    }
    case CalibrationFailure::LateCamera: {
      const CaptureOptions options{.frames = 150, .late_camera = 2};
      return capture(four, two_sided, wandering(options), options);
    }
  }
  return {};
}

}  // namespace floatstage::calib
