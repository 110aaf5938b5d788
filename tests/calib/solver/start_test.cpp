// Where the solver starts: near enough to the truth, and a sentence where there is no way.

#include "calib/solver/start.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/solver/failures.h"
#include "calib/solver/wand_start.h"
#include "tests/calib/solver/solver_scenes.h"
#include "tests/support/matchers.h"

namespace floatstage::calib::solver {
namespace {

const CaptureOptions kCapture{.frames = 40, .noise_px = 0.1, .outliers = 0.02, .frame_seconds = 0.4};

Scene unsolved(const TrueScene& s) { return make_scene(s.seen); }

// Of each camera the place seen from the first, against the truth's, as a share of the ring's radius.
double worst_place(const Scene& scene, const Rig& truth) {
  double worst = 0;
  const Rigid3 first = scene.cameras[0].cam_from_world, true_first = truth.cameras[0].cam_from_world;
  for (std::size_t c = 1; c < scene.cameras.size(); ++c)
    worst = std::max(worst, (first * scene.cameras[c].cam_from_world.center() -
                             true_first * truth.cameras[c].cam_from_world.center())
                                    .norm() /
                                3);
  return worst;
}

TEST(StartIntrinsics, FindsAFocalLengthNearby) {
  const TrueScene s = true_scene(3, kCapture);
  Scene scene = unsolved(s);
  for (int c = 0; c < 3; ++c) {
    ASSERT_THAT(start_intrinsics(scene, c), IsOk());
    const double truth = s.truth.cameras[static_cast<std::size_t>(c)].model.fx;
    EXPECT_NEAR(scene.cameras[static_cast<std::size_t>(c)].intrinsics[0] / truth, 1, 0.1);
  }
}

TEST(StartIntrinsics, NamesTheCameraThatSawNoBoard) {
  TrueScene s = true_scene(3, kCapture);
  std::erase_if(s.seen.views, [](const TargetView& v) { return v.camera == 1; });
  Scene scene = unsolved(s);
  EXPECT_THAT(start_intrinsics(scene, 1), FailsWith(ErrorCode::BadData, "cam1"));
}

TEST(StartPoses, PlacesAllCamerasAndBoardsNearTheTruth) {
  const TrueScene s = true_scene(5, kCapture);
  Scene scene = unsolved(s);
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    scene.cameras[c].intrinsics = pack(s.truth.cameras[c].model);
    scene.cameras[c].has_intrinsics = true;
  }
  const Result<std::vector<CameraPair>> pairs = start_poses(scene, 1);
  ASSERT_THAT(pairs, IsOk());
  EXPECT_EQ(std::count_if(pairs->begin(), pairs->end(), [](const CameraPair& p) { return p.in_tree; }), 4);
  EXPECT_LT(worst_place(scene, s.truth), 0.02);
}

TEST(StartPoses, NamesTheCamerasThatNothingJoins) {
  TrueScene s = true_scene(4, kCapture);
  // The last camera saw the board only where nobody else did.
  std::erase_if(s.seen.views, [](const TargetView& v) { return (v.camera == 3) != (v.frame % 2 == 0); });
  Scene scene = unsolved(s);
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    scene.cameras[c].intrinsics = pack(s.truth.cameras[c].model);
    scene.cameras[c].has_intrinsics = true;
  }
  EXPECT_THAT(start_poses(scene, 1), FailsWith(ErrorCode::BadData, "cam3"));
}

TEST(PoseFromWand, FindsTheOtherCameraAndItsDistance) {
  const Rig truth = ring_rig(4);
  const Observations seen = capture(truth, wand({0, 0.3, 0.8}, 1e-3), wandering(kCapture),
                                    {.frames = 60, .noise_px = 0.2, .outliers = 0.02, .frame_seconds = 0.4});
  Scene scene = make_scene(seen);
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    scene.cameras[c].intrinsics = pack(truth.cameras[c].model);
    scene.cameras[c].has_intrinsics = true;
  }
  ASSERT_GE(wand_overlap(scene, 0, 1).points, kFewestWandPoints);
  const std::optional<Rigid3> a_from_b = pose_from_wand(scene, 0, 1);
  ASSERT_TRUE(a_from_b);
  const Rigid3 expected = truth.cameras[0].cam_from_world * truth.cameras[1].cam_from_world.inverse();
  EXPECT_LT((a_from_b->translation - expected.translation).norm(), 0.05);
  EXPECT_LT(angle_between(a_from_b->rotation, expected.rotation), 0.02);
}

TEST(PoseFromWand, NeedsEnoughOfTheWand) {
  const Rig truth = ring_rig(2);
  const Observations seen = capture(truth, wand({0, 0.3, 0.8}, 1e-3), wandering(kCapture), {.frames = 3});
  Scene scene = make_scene(seen);
  for (std::size_t c = 0; c < scene.cameras.size(); ++c)
    scene.cameras[c].intrinsics = pack(truth.cameras[c].model);
  EXPECT_LT(wand_overlap(scene, 0, 1).points, kFewestWandPoints);
  EXPECT_FALSE(pose_from_wand(scene, 0, 1));
}

TEST(WrongLayouts, AreNoneForABoardAsItIsAndOneForRowsAndColumnsExchanged) {
  Observations seen = capture(ring_rig(3), grid_board(7, 5, 0.09), wandering(kCapture), kCapture);
  EXPECT_THAT(wrong_layouts(make_scene(seen)), testing::IsEmpty());
  Target& board = seen.targets[0];
  board.grid = TargetGrid{5, 7, 0.09};
  for (TargetPoint& p : board.points) p.position = {0.09 * (p.id % 5), 0.09 * (p.id / 5), 0};
  const std::vector<NamedFailure> wrong = wrong_layouts(make_scene(seen));
  ASSERT_THAT(wrong, testing::SizeIs(1));
  EXPECT_EQ(wrong[0].kind, CalibrationFailure::SwappedRowsColumns);
}

}  // namespace
}  // namespace floatstage::calib::solver
