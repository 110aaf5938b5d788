// What makes a small reprojection error worthless is named; and a sound capture is not accused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/calibrate.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"

namespace floatstage {

void PrintTo(const NamedFailure& f, std::ostream* out) { *out << name_of(f.kind) << " (" << f.camera << "): " << f.sentence; }

namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

auto named(CalibrationFailure kind) { return Field(&NamedFailure::kind, kind); }
auto named(CalibrationFailure kind, const std::string& camera, const std::string& words) {
  return AllOf(Field(&NamedFailure::kind, kind), Field(&NamedFailure::camera, camera), Field(&NamedFailure::sentence, HasSubstr(words)));
}

std::vector<NamedFailure> failures_of(const Observations& seen, const CalibrationOptions& options = {}) {
  const Result<Calibration> solved = calibrate(seen, options);
  EXPECT_THAT(solved, IsOk());
  return solved ? solved->failures : std::vector<NamedFailure>{};
}

// A board that keeps a distance from the only camera and turns and tilts there.
Path in_front(const RigCamera& camera, double nearest, double farthest, double tilt_degrees) {
  const Rigid3 world_from_cam = camera.cam_from_world.inverse();
  return [=](double t) {
    const double distance = nearest + (farthest - nearest) * (0.5 + 0.5 * std::sin(1.3 * t)), tilt = tilt_degrees * std::numbers::pi / 180;
    const Eigen::Vector3d place(0.25 * distance * std::sin(1.1 * t), 0.2 * distance * std::sin(1.7 * t), distance);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(tilt * std::sin(2.3 * t), Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(tilt * std::cos(2.9 * t), Eigen::Vector3d::UnitY()));
    return world_from_cam * Rigid3{turn, place};
  };
}

const CaptureOptions kStills{.frames = 40, .frame_seconds = 0.2};

TEST(NamedFailures, AreNoneInASoundCapture) {
  const Rig rig = ring_rig(1);
  EXPECT_THAT(failures_of(capture(rig, grid_board(7, 5, 0.06), in_front(rig.cameras[0], 1.2, 2.5, 35), kStills)), IsEmpty());
}

TEST(NamedFailures, NameACaptureAtOneDistance) {
  const Rig rig = ring_rig(1);
  EXPECT_THAT(failures_of(capture(rig, grid_board(7, 5, 0.04), in_front(rig.cameras[0], 2, 2.05, 15), kStills)),
              ElementsAre(named(CalibrationFailure::ConstantDepth, "cam0", "nearer and farther")));
}

TEST(NamedFailures, NameABoardThatIsNeverTilted) {
  const Rig rig = ring_rig(1);
  EXPECT_THAT(failures_of(capture(rig, grid_board(7, 5, 0.06), in_front(rig.cameras[0], 1.2, 2.5, 0), kStills)),
              ElementsAre(named(CalibrationFailure::PlanarMotion, "cam0", "tilt the board")));
}

TEST(NamedFailures, DoNotBlameACaptureForIntrinsicsThatAreKnown) {
  const Rig rig = ring_rig(1);
  Observations seen = capture(rig, grid_board(7, 5, 0.06), in_front(rig.cameras[0], 2, 2.05, 0), kStills);
  seen.cameras[0].intrinsics = Prior::Fixed;
  seen.cameras[0].model = rig.cameras[0].model;
  EXPECT_THAT(failures_of(seen), IsEmpty());
}

TEST(NamedFailures, NameRowsAndColumnsThatWereSwapped) {
  const Rig rig = ring_rig(1);
  Observations seen = capture(rig, grid_board(7, 5, 0.06), in_front(rig.cameras[0], 1.2, 2.5, 35), kStills);
  seen.targets[0] = grid_board(5, 7, 0.06);
  EXPECT_THAT(failures_of(seen), ElementsAre(named(CalibrationFailure::SwappedRowsColumns, "", "7 columns and 5 rows")));
}

TEST(NamedFailures, NameASquareSizeThatAWandContradicts) {
  const Rig rig = ring_rig(4);
  CaptureOptions options{.frames = 60, .frame_seconds = 0.2};
  Observations seen = capture(rig, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  const Path path = wandering(options);
  capture_more(seen, rig, wand({0, 0.3, 0.7}, 2e-4), path, options);
  EXPECT_THAT(failures_of(seen), IsEmpty());
  seen.targets[0] = two_sided_board(7, 5, 0.084, 0.005);  // it was printed smaller than is believed
  EXPECT_THAT(failures_of(seen), Contains(named(CalibrationFailure::WrongSquareSize, "", "5.0 % larger")));
}

TEST(NamedFailures, NameASquareSizeThatFixedPosesContradict) {
  const Rig rig = ring_rig(4);
  CaptureOptions options{.frames = 40, .frame_seconds = 0.2};
  Observations seen = capture(rig, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  for (std::size_t c = 0; c < 4; ++c) {
    seen.cameras[c].intrinsics = seen.cameras[c].pose = Prior::Fixed;
    seen.cameras[c].model = rig.cameras[c].model;
    seen.cameras[c].cam_from_world = rig.cameras[c].cam_from_world;
  }
  EXPECT_THAT(failures_of(seen), IsEmpty());
  seen.targets[0] = two_sided_board(7, 5, 0.084, 0.005);
  EXPECT_THAT(failures_of(seen), Contains(named(CalibrationFailure::WrongSquareSize, "", "fixed camera poses")));
}

TEST(NamedFailures, NameAMirroredBoard) {
  const Rig rig = ring_rig(2);
  Observations seen = capture(rig, grid_board(7, 5, 0.06), in_front(rig.cameras[0], 1.2, 2.5, 35), kStills);
  for (TargetPoint& p : seen.targets[0].points) p.position.x() *= -1;
  seen.cameras.resize(1);
  std::erase_if(seen.views, [](const TargetView& v) { return v.camera != 0; });
  EXPECT_THAT(failures_of(seen), ElementsAre(named(CalibrationFailure::MirroredBoard, "", "mirror")));
}

TEST(NamedFailures, NameTheOneCameraThatIsAFrameLate) {
  const Rig rig = ring_rig(4);
  CaptureOptions options{.frames = 150};
  options.late_camera = 2;
  const Observations seen = capture(rig, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  const std::vector<NamedFailure> found = failures_of(seen);
  EXPECT_THAT(found, ElementsAre(named(CalibrationFailure::LateCamera, "cam2", "frames late")));
}

TEST(NamedFailures, DoNotCallPunctualCamerasLate) {
  const Rig rig = ring_rig(4);
  const CaptureOptions options{.frames = 150};
  EXPECT_THAT(failures_of(capture(rig, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options)), Not(Contains(named(CalibrationFailure::LateCamera))));
}

TEST(NamedFailures, HaveStableNames) {
  EXPECT_STREQ(name_of(CalibrationFailure::ConstantDepth), "constant-depth");
  EXPECT_STREQ(name_of(CalibrationFailure::PlanarMotion), "planar-motion");
  EXPECT_STREQ(name_of(CalibrationFailure::SwappedRowsColumns), "swapped-rows-columns");
  EXPECT_STREQ(name_of(CalibrationFailure::WrongSquareSize), "wrong-square-size");
  EXPECT_STREQ(name_of(CalibrationFailure::MirroredBoard), "mirrored-board");
  EXPECT_STREQ(name_of(CalibrationFailure::LateCamera), "late-camera");
}

}  // namespace
}  // namespace floatstage
