// What makes a small reprojection error worthless is named; and a sound capture is not accused.

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/calibrate.h"
#include "tests/calib/failing_captures.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {

void PrintTo(const NamedFailure& f, std::ostream* out) {
  *out << name_of(f.kind) << " (" << f.camera << "): " << f.sentence;
}

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
  return AllOf(Field(&NamedFailure::kind, kind), Field(&NamedFailure::camera, camera),
               Field(&NamedFailure::sentence, HasSubstr(words)));
}

std::vector<NamedFailure> failures_of(const Observations& seen, const CalibrationOptions& options = {}) {
  const Result<Calibration> solved = calibrate(seen, options);
  EXPECT_THAT(solved, IsOk());
  return solved ? solved->failures : std::vector<NamedFailure>{};
}

TEST(NamedFailures, AreNoneInASoundCapture) {
  const Rig rig = ring_rig(1);
  EXPECT_THAT(
      failures_of(capture(rig, grid_board(7, 5, 0.06), in_front(rig.cameras[0], 1.2, 2.5, 35), kStills)),
      IsEmpty());
}

TEST(NamedFailures, NameACaptureAtOneDistance) {
  EXPECT_THAT(failures_of(failing_capture(CalibrationFailure::ConstantDepth)),
              ElementsAre(named(CalibrationFailure::ConstantDepth, "cam0", "nearer and farther")));
}

TEST(NamedFailures, NameABoardThatIsNeverTilted) {
  EXPECT_THAT(failures_of(failing_capture(CalibrationFailure::PlanarMotion)),
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
  EXPECT_THAT(failures_of(failing_capture(CalibrationFailure::SwappedRowsColumns)),
              ElementsAre(named(CalibrationFailure::SwappedRowsColumns, "", "7 columns and 5 rows")));
}

TEST(NamedFailures, NameASquareSizeThatAWandContradicts) {
  Observations seen = failing_capture(CalibrationFailure::WrongSquareSize);
  EXPECT_THAT(failures_of(seen), Contains(named(CalibrationFailure::WrongSquareSize, "", "5.0 % larger")));
  seen.targets[0] = two_sided_board(7, 5, 0.08, 0.005);  // as it was printed
  EXPECT_THAT(failures_of(seen), IsEmpty());
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
  EXPECT_THAT(failures_of(seen),
              Contains(named(CalibrationFailure::WrongSquareSize, "", "fixed camera poses")));
}

TEST(NamedFailures, NameAMirroredBoard) {
  EXPECT_THAT(failures_of(failing_capture(CalibrationFailure::MirroredBoard)),
              ElementsAre(named(CalibrationFailure::MirroredBoard, "", "mirror")));
}

TEST(NamedFailures, NameTheOneCameraThatIsAFrameLate) {
  const std::vector<NamedFailure> found = failures_of(failing_capture(CalibrationFailure::LateCamera));
  EXPECT_THAT(found, ElementsAre(named(CalibrationFailure::LateCamera, "cam2", "frames late")));
}

TEST(NamedFailures, DoNotCallPunctualCamerasLate) {
  const Rig rig = ring_rig(4);
  const CaptureOptions options{.frames = 150};
  EXPECT_THAT(failures_of(capture(rig, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options)),
              Not(Contains(named(CalibrationFailure::LateCamera))));
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
}  // namespace floatstage::calib
