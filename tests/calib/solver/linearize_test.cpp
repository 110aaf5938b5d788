// Derivatives written by hand, against differences.

#include "calib/solver/linearize.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/solver/projection.h"
#include "calib/solver/timing.h"
#include "tests/calib/synthetic_capture.h"

namespace floatstage::calib::solver {
namespace {

Intrinsics sample(LensKind lens) {
  Intrinsics in;
  in << 800, 790, 320, 240, -0.1, 0.03, 0.002, -0.003, 0.01, 0.2, -0.05, 0.02, 1.7;
  if (lens == LensKind::KannalaBrandt)
    in.segment<kLensRows>(kLensRow) << -0.02, 0.01, -0.003, 0.0004, 0, 0, 0, 0;
  if (lens == LensKind::None) in.segment<kLensRows>(kLensRow).setZero();
  return in;
}

class EveryLens : public testing::TestWithParam<LensKind> {};
INSTANTIATE_TEST_SUITE_P(Lenses, EveryLens,
                         testing::Values(LensKind::None, LensKind::BrownConrady, LensKind::KannalaBrandt));

TEST_P(EveryLens, ProjectsAsCoreDoes) {
  const CameraModel model = unpack(sample(GetParam()), GetParam(), 640, 480);
  for (const Eigen::Vector3d& x :
       {Eigen::Vector3d(0.2, -0.1, 1), Eigen::Vector3d(0, 0, 2), Eigen::Vector3d(-0.9, 0.6, 1.5)}) {
    Projected p;
    ASSERT_TRUE(project(sample(GetParam()), GetParam(), x, p));
    EXPECT_LT((p.pixel - *floatstage::project(model, x)).norm(), 1e-10);
  }
  EXPECT_EQ(pack(model), sample(GetParam()));
}

TEST_P(EveryLens, KnowsHowAPixelChanges) {
  const Eigen::Vector3d x(0.3, -0.2, 1.1);
  Projected here, there;
  ASSERT_TRUE(project(sample(GetParam()), GetParam(), x, here));
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 3; ++k) {
    Eigen::Vector3d moved = x;
    moved[k] += kStep;
    project(sample(GetParam()), GetParam(), moved, there);
    EXPECT_LT(((there.pixel - here.pixel) / kStep - here.by_point.col(k)).norm(), 1e-2) << "coordinate " << k;
  }
  for (int k = 0; k < 4 + coefficient_count(GetParam()); ++k) {
    Intrinsics moved = sample(GetParam());
    moved[k] += kStep;
    project(moved, GetParam(), x, there);
    EXPECT_LT(((there.pixel - here.pixel) / kStep - here.by_intrinsics.col(k)).norm(), 1e-3)
        << "parameter " << k;
  }
}

TEST(Project, RefusesWhatIsBehindTheCamera) {
  Projected p;
  EXPECT_FALSE(project(sample(LensKind::None), LensKind::None, {0, 0, -1}, p));
  EXPECT_FALSE(project(sample(LensKind::None), LensKind::None, {0, 0, 0}, p));
}

// A scene of one moving board (and one wand) in one camera, not at its solution.
Scene scene_of(bool markers) {
  CaptureOptions options{.frames = 5, .noise_px = 0.5, .outliers = 0.2, .steepest_degrees = 88};
  const Rig truth = ring_rig(2);
  const Target target = markers ? wand({0, 0.2, 0.5}, 1e-3) : grid_board(6, 5, 0.06);
  const Observations seen = capture(truth, target, wandering(options, 3), options);
  Scene scene = make_scene(seen);
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    scene.cameras[c].intrinsics = pack(truth.cameras[c].model);
    scene.cameras[c].cam_from_world = truth.cameras[c].cam_from_world;
    scene.cameras[c].placed = true;
    scene.cameras[c].offset = 0.004;
  }
  for (SceneBoard& b : scene.boards) {
    b.world_from_target = wandering(options, 3)(b.frame * options.frame_seconds);
    b.placed = true;
  }
  for (SceneMarkers& m : scene.markers) {
    for (std::size_t i = 0; i < m.positions.size(); ++i)
      m.positions[i] = {0.1 * static_cast<double>(i), 0.05 * m.frame, 1};
    m.placed = true;
  }
  estimate_motion(scene);
  return scene;
}

double half_squares(const Scene& scene, const SceneView& view, Loss loss) {
  LinearView v;
  linearize(scene, view, loss, false, v);
  return 0.5 * v.residual.squaredNorm();
}

struct Case {
  bool markers;
  double cauchy;
  bool free_motion = false;
};
class EveryView : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Views, EveryView,
                         testing::Values(Case{false, 0}, Case{false, 2}, Case{true, 0}, Case{true, 2},
                                         Case{false, 2, true}));

TEST_P(EveryView, HasTheGradientOfItsSumOfSquares) {
  Scene scene = scene_of(GetParam().markers);
  const Loss loss{GetParam().cauchy};
  if (GetParam().free_motion) free_motion(scene);
  int moving = 0;
  for (const SceneView& view : scene.views) {
    const bool moves = view.board >= 0 ? scene.boards[static_cast<std::size_t>(view.board)].has_motion
                                       : scene.markers[static_cast<std::size_t>(view.markers)].has_motion;
    if (!moves) continue;
    ++moving;
    LinearView linear;
    linearize(scene, view, loss, true, linear);
    ASSERT_TRUE(linear.valid);
    EXPECT_NEAR(0.5 * linear.residual.squaredNorm(), half_squares(scene, view, loss),
                1e-9 * linear.residual.squaredNorm());
    SceneCamera& camera = scene.cameras[static_cast<std::size_t>(view.camera)];
    const auto slope = [&](double& value, double step) {
      const double kept = value;
      value = kept + step;
      const double up = half_squares(scene, view, loss);
      value = kept - step;
      const double down = half_squares(scene, view, loss);
      value = kept;
      return (up - down) / (2 * step);
    };
    const auto turn = [&](Rigid3& pose, int axis) {
      constexpr double kStep = 1e-6;
      const Rigid3 kept = pose;
      pose.rotation = rotation_from_vector(kStep * Eigen::Vector3d::Unit(axis)) * kept.rotation;
      const double up = half_squares(scene, view, loss);
      pose.rotation = rotation_from_vector(-kStep * Eigen::Vector3d::Unit(axis)) * kept.rotation;
      const double down = half_squares(scene, view, loss);
      pose = kept;
      return (up - down) / (2 * kStep);
    };
    const double scale = 1e-4 * (1 + linear.residual.norm() * linear.by_camera.norm());
    const Eigen::VectorXd by_intrinsics = linear.by_intrinsics.transpose() * linear.residual,
                          by_camera = linear.by_camera.transpose() * linear.residual,
                          by_object = linear.by_object.transpose() * linear.residual;
    for (int k = 0; k < kIntrinsics; ++k)
      EXPECT_NEAR(by_intrinsics[k], slope(camera.intrinsics[k], 1e-6), scale) << "parameter " << k;
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(by_camera[k], turn(camera.cam_from_world, k), scale);
      EXPECT_NEAR(by_camera[3 + k], slope(camera.cam_from_world.translation[k], 1e-6), scale);
    }
    if (view.board >= 0) {
      SceneBoard& board = scene.boards[static_cast<std::size_t>(view.board)];
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(by_object[k], turn(board.world_from_target, k), scale);
        EXPECT_NEAR(by_object[3 + k], slope(board.world_from_target.translation[k], 1e-6), scale);
        if (!GetParam().free_motion) continue;
        EXPECT_NEAR(by_object[6 + k], slope(board.spin[k], 1e-5), scale);
        EXPECT_NEAR(by_object[9 + k], slope(board.velocity[k], 1e-5), scale);
      }
    } else {
      SceneMarkers& m = scene.markers[static_cast<std::size_t>(view.markers)];
      for (Eigen::Index k = 0; k < by_object.size(); ++k)
        EXPECT_NEAR(by_object[k], slope(m.positions[static_cast<std::size_t>(k / 3)][k % 3], 1e-6), scale);
    }
    EXPECT_NEAR(linear.by_offset.dot(linear.residual), slope(camera.offset, 1e-6), scale);
  }
  EXPECT_GT(moving, 2);
}

// What is eliminated must be what would have been solved for: the least over all instants of the picture.
TEST(Jitter, IsEliminatedAtItsLikeliestValue) {
  Scene scene = scene_of(false);
  constexpr double kSigma = 2e-4;
  int moving = 0;
  for (SceneView& view : scene.views) {
    if (!scene.boards[static_cast<std::size_t>(view.board)].has_motion) continue;
    ++moving;
    scene.jitter_sigma = kSigma;
    LinearView eliminated;
    for (int i = 0; i < 20; ++i) {  // linear around itself, it is exact
      linearize(scene, view, {}, true, eliminated);
      view.jitter = eliminated.jitter;
    }
    scene.jitter_sigma = 0;
    const auto cost = [&](double jitter) {
      view.jitter = jitter;
      const double squares = half_squares(scene, view, {});
      view.jitter = 0;
      return squares + 0.5 * jitter * jitter / (kSigma * kSigma);
    };
    const double least = cost(eliminated.jitter);
    EXPECT_NEAR(0.5 * eliminated.residual.squaredNorm(), least, 1e-3 * least);
    EXPECT_LT(least, cost(eliminated.jitter + 0.2 * eliminated.jitter_sigma));
    EXPECT_LT(least, cost(eliminated.jitter - 0.2 * eliminated.jitter_sigma));
    EXPECT_LT(eliminated.jitter_sigma, kSigma);
  }
  EXPECT_GT(moving, 2);
}

TEST(Regroup, PutsALateViewToTheFrameThatItShows) {
  Scene scene = scene_of(false);
  scene.cameras[1].offset = -0.9 * scene.period;
  const std::vector<SceneView> before = scene.views;
  ASSERT_GT(regroup(scene), 0);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const SceneBoard &old = scene.boards[static_cast<std::size_t>(before[i].board)],
                     &now = scene.boards[static_cast<std::size_t>(scene.views[i].board)];
    EXPECT_EQ(now.frame, before[i].camera == 1 && old.frame > 0 ? old.frame - 1 : old.frame);
    EXPECT_NEAR(now.time + scene.views[i].lag, old.time + before[i].lag,
                1e-12);  // it was taken when it was taken
  }
  EXPECT_EQ(regroup(scene), 0);
}

TEST(MarkerResidual, HasTheDerivativeOfLengthsAndSurveyedPlaces) {
  Target target = wand({0, 0.2, 0.5}, 1e-3);
  target.positions_sigma = 0.01;
  SceneMarkers markers;
  markers.indices = {0, 1, 2};
  markers.positions = {{0, 0, 1}, {0.1, 0.15, 1.1}, {0.2, 0.4, 1.3}};
  Eigen::MatrixXd j;
  const Eigen::VectorXd here = marker_residual(markers, target, &j);
  ASSERT_EQ(here.size(), 2 + 9);
  for (std::size_t k = 0; k < 9; ++k) {
    SceneMarkers moved = markers;
    moved.positions[k / 3][static_cast<Eigen::Index>(k % 3)] += 1e-7;
    const Eigen::VectorXd difference = (marker_residual(moved, target, nullptr) - here) / 1e-7;
    EXPECT_LT((difference - j.col(static_cast<Eigen::Index>(k))).norm(), 1e-2) << k;
  }
}

TEST(MarkerResidual, PassesOverLengthsToMarkersThatNobodySaw) {
  SceneMarkers markers;
  markers.indices = {0, 2};
  markers.positions = {{0, 0, 1}, {0.2, 0.4, 1.3}};
  EXPECT_EQ(marker_residual(markers, wand({0, 0.2, 0.5}, 1e-3), nullptr).size(), 0);
}

}  // namespace
}  // namespace floatstage::calib::solver
