// The solver against rigs whose truth is exact.

#include "calib/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/text.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

using testing::IsEmpty;

void expect_true(const Result<Calibration>& solved, const Rig& truth, const CaptureOptions& options) {
  ASSERT_THAT(solved, IsOk());
  EXPECT_THAT(solved->failures, IsEmpty());
  const TruthErrors e = compare(solved->rig, truth, options);
  testing::Test::RecordProperty("grid_mm", text(e.grid_mm));
  EXPECT_LE(e.focal, 0.0005);
  EXPECT_LE(e.rotation_degrees, 0.01);
  EXPECT_LE(e.grid_mm, 0.3);
}

TEST(Calibrate, FindsARingOfEight) {
  const Rig truth = ring_rig(8);
  const CaptureOptions options{.frames = 240, .extent = 0.9, .frame_seconds = 0.2};
  expect_true(calibrate(capture(truth, two_sided_board(10, 8, 0.1, 0.006), wandering(options), options)),
              truth, options);
}

TEST(Calibrate, ChainsTwoGroupsWithoutACommonViewThroughATwoSidedBoard) {
  const Rig truth = facing_rig();
  const CaptureOptions options{.frames = 200, .extent = 0.9, .frame_seconds = 0.2};
  expect_true(calibrate(capture(truth, two_sided_board(10, 8, 0.1, 0.006), wandering(options), options)),
              truth, options);
}

TEST(Calibrate, FindsFisheyesBesideALongLens) {
  const Rig truth = mixed_rig();
  const CaptureOptions options{.frames = 400, .extent = 0.6, .frame_seconds = 0.2};
  expect_true(calibrate(capture(truth, two_sided_board(10, 8, 0.1, 0.006), wandering(options), options)),
              truth, options);
}

TEST(Calibrate, FindsADomeOfTwenty) {
  const Rig truth = dome_rig(20);
  const CaptureOptions options{.frames = 200, .extent = 0.9, .frame_seconds = 0.2};
  expect_true(calibrate(capture(truth, two_sided_board(10, 8, 0.1, 0.006), wandering(options), options)),
              truth, options);
}

}  // namespace
}  // namespace floatstage::calib
