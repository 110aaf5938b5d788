#include <numbers>

#include <gtest/gtest.h>

#include "calib/calibrate.h"
#include "calib/detect.h"
#include "core/random.h"
#include "tests/calib/detections.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

// Four cameras on a quarter circle with lenses of their own.
Rig arc_rig() {
  Rig rig;
  for (int i = 0; i < 4; ++i) {
    const double angle = (30 * i - 45) * std::numbers::pi / 180;
    const Eigen::Vector3d eye(2.4 * std::sin(angle), -2.4 * std::cos(angle), 1.2 + 0.15 * i);
    CameraModel model = test::simple_camera(
        1280, 720, 56 + 3 * i, BrownConrady{.k1 = -0.15 + 0.03 * i, .k2 = 0.04, .p1 = 0.0005, .p2 = -0.0003});
    model.cx += 4 - 3 * i, model.cy += 2 * i - 5;
    rig.cameras.push_back({.serial = text("cam", i),
                           .model = model,
                           .cam_from_world = look_at(eye, {0, 0, 1}, {0, 0, 1}),
                           .color = {}});
  }
  return rig;
}

// A board that faces the arc, here and there, turned this way and that.
Rigid3 board_in_world(const TargetDesign& design, Random& random) {
  const auto tilt = [&](double most) { return random.uniform(-most, most) * std::numbers::pi / 180; };
  const Eigen::Vector3d center(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7),
                               random.uniform(0.55, 1.55));
  // Upright, its z towards the cameras (-y).
  const Eigen::Quaterniond upright(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond turned = Eigen::AngleAxisd(tilt(45), Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(tilt(35), Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(tilt(40), Eigen::Vector3d::UnitY()) * upright;
  const std::vector<Eigen::Vector3d> points = target_points(design);
  return {turned, center - turned * (0.5 * (points.front() + points.back()))};
}

TEST(RenderedBoards, AreCalibratedToTheirTruth) {
  const TargetDesign design = target("charuco columns=6 rows=8 square=80mm marker=60mm dictionary=5x5_100");
  const Rig truth = arc_rig();
  constexpr int kFrames = 36;
  Random random(11);
  Observations seen;
  for (const RigCamera& c : truth.cameras)
    seen.cameras.push_back({.serial = c.serial,
                            .width = c.model.width,
                            .height = c.model.height,
                            .model = {},
                            .cam_from_world = {}});
  seen.targets.push_back(make_target(design, "board"));
  for (int frame = 0; frame < kFrames; ++frame) {
    const Rigid3 world_from_board = board_in_world(design, random);
    for (int camera = 0; camera < 4; ++camera) {
      const RigCamera& c = truth.cameras[static_cast<std::size_t>(camera)];
      const Image picture = test::board_picture(
          design, c.model, c.cam_from_world * world_from_board,
          {.blur = 0.7, .noise = 2, .seed = static_cast<std::uint64_t>(100 * frame + camera)});
      const Detection found = detect(design, picture, {.diagnose = false});
      if (found.points.empty()) continue;
      seen.views.push_back(
          {.camera = camera, .target = 0, .frame = frame, .time = {}, .points = found.points});
    }
  }
  EXPECT_GE(seen.views.size(), 2u * kFrames);
  const Result<Calibration> solved = calibrate(seen);
  ASSERT_THAT(solved, IsOk());
  for (const CameraQuality& q : solved->cameras) {
    EXPECT_LE(q.rms_px, 0.2) << q.serial;
    EXPECT_LE(q.holdout_px, 0.2) << q.serial;
  }
  CaptureOptions volume;
  volume.extent = 0.5;
  const TruthErrors errors = compare(solved->rig, truth, volume);
  std::printf("rms %.3f px, focal %.4f %%, rotation %.4f degrees, grid %.3f mm\n", *solved->cameras[0].rms_px,
              100 * errors.focal, errors.rotation_degrees, errors.grid_mm);
  EXPECT_LE(errors.rotation_degrees, 0.02);
  EXPECT_LE(errors.grid_mm, 1);
  EXPECT_LE(errors.focal, 0.001);
}

}  // namespace
}  // namespace floatstage::calib
