// Which world a solution is moved into, and that nothing but the world moves.

#include "calib/solver/gauge.h"

#include <numbers>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/solver/bundle.h"
#include "core/rig.h"
#include "tests/calib/solver/solver_scenes.h"
#include "tests/support/matchers.h"

namespace floatstage::calib::solver {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kDegrees = 180 / std::numbers::pi;

const Rigid3 kElsewhere{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, -1).normalized())),
                        {0.4, -1.2, 2.5}};

class SetGauge : public testing::Test {
 protected:
  SetGauge() : given_(true_scene(4, {.frames = 12, .noise_px = 0, .outliers = 0, .frame_seconds = 0.4})) {
    covariance_ = MatrixXd::Zero(rows(), rows());
  }

  Eigen::Index rows() const {
    return kCameraParameters * static_cast<Eigen::Index>(given_.scene.cameras.size());
  }

  // The solution in a world of its own, as it comes from the solver.
  void turn_the_world() {
    const Rigid3 back = kElsewhere.inverse();
    for (SceneCamera& c : given_.scene.cameras) c.cam_from_world = c.cam_from_world * back;
    for (SceneBoard& b : given_.scene.boards) b.world_from_target = kElsewhere * b.world_from_target;
  }

  Result<void> set(const Gauge& gauge) {
    given_.seen.gauge = gauge;
    return set_gauge(given_.scene, given_.seen, covariance_, remarks_);
  }

  // Sigma² of the pixel of a point of the camera's frame by its pose.
  Eigen::Matrix2d pixel_covariance(std::size_t camera, const Vector3d& in_camera) const {
    const SceneCamera& c = given_.scene.cameras[camera];
    Projected p;
    EXPECT_TRUE(project(c.intrinsics, c.lens, in_camera, p));
    Eigen::Matrix<double, 3, 6> by_pose;
    by_pose << -cross_matrix(in_camera - c.cam_from_world.translation), Eigen::Matrix3d::Identity();
    const Eigen::Matrix<double, 2, 6> j = p.by_point * by_pose;
    const Eigen::Index at = kCameraParameters * static_cast<Eigen::Index>(camera) + kIntrinsics;
    return j * covariance_.block<6, 6>(at, at) * j.transpose();
  }

  TrueScene given_;
  MatrixXd covariance_;
  std::vector<std::string> remarks_;
};

TEST_F(SetGauge, LaysTheFloorBoardOnTheFloor) {
  turn_the_world();
  const SceneBoard& board = given_.scene.boards[5];
  ASSERT_THAT(set(FloorBoard{.target = 0, .frame = board.frame, .height = 0.012}), IsOk());
  const Rigid3& place = board.world_from_target;
  EXPECT_LT((place.translation - Vector3d(0, 0, 0.012)).norm(), 1e-12);
  EXPECT_LT((place.rotation * Vector3d::UnitX() - Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_LT(largest_error(given_.scene), 1e-6) << "nothing moves against the cameras";
}

TEST_F(SetGauge, PutsTheFirstCameraThatSawTheFloorAboveIt) {
  std::set<int> boards;  // printed on both sides: other cameras may look at its back
  for (const SceneView& v : given_.scene.views) {
    if (!boards.insert(v.board).second) continue;
    SCOPED_TRACE(v.board);
    const int frame = given_.scene.boards[static_cast<std::size_t>(v.board)].frame;
    ASSERT_THAT(set(FloorBoard{.target = 0, .frame = frame, .height = 0}), IsOk());
    EXPECT_GT(given_.scene.cameras[static_cast<std::size_t>(v.camera)].cam_from_world.center().z(), 0);
  }
}

TEST_F(SetGauge, RefusesAFloorThatNobodySaw) {
  EXPECT_THAT(set(FloorBoard{.target = 0, .frame = 999, .height = 0}),
              FailsWith(ErrorCode::BadData, "target 'board' in frame 999"));
}

TEST_F(SetGauge, PutsTheCameraWhereAHandPutIt) {
  const Rigid3 wanted{Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Vector3d::UnitY())), {1, 2, 3}};
  ASSERT_THAT(set(HandSet{.camera = 2, .cam_from_world = wanted}), IsOk());
  const Rigid3& is = given_.scene.cameras[2].cam_from_world;
  EXPECT_LT((is.translation - wanted.translation).norm(), 1e-12);
  EXPECT_LT(angle_between(is.rotation, wanted.rotation), 1e-9);
  EXPECT_LT(largest_error(given_.scene), 1e-6);
  EXPECT_THAT(remarks_, testing::IsEmpty());
}

TEST_F(SetGauge, LeavesAWorldThatIsHeldAlready) {
  given_.scene.reference = -1;
  const Rigid3 before = given_.scene.cameras[1].cam_from_world;
  ASSERT_THAT(set(OwnGauge{}), IsOk());
  EXPECT_EQ(given_.scene.cameras[1].cam_from_world.translation, before.translation);
}

TEST_F(SetGauge, StandsUprightAboveTheOriginWhereNothingIsKnown) {
  turn_the_world();
  ASSERT_THAT(set(OwnGauge{}), IsOk());
  EXPECT_THAT(remarks_, testing::ElementsAre(testing::HasSubstr("by the cameras alone")));
  Rig rig;
  for (const SceneCamera& c : given_.scene.cameras)
    rig.cameras.push_back({c.serial, {}, c.cam_from_world, {}});
  EXPECT_LT((mean_up(rig).normalized() - Vector3d::UnitZ()).norm(), 1e-6);
  EXPECT_LT(focus_point(rig).norm(), 1e-6);
  EXPECT_LT(largest_error(given_.scene), 1e-6);
}

TEST_F(SetGauge, GoesBackToWhereMostCamerasWereWhenOneHasMoved) {
  for (std::size_t c = 0; c < given_.seen.cameras.size(); ++c) {
    given_.seen.cameras[c].pose = Prior::Start;
    given_.seen.cameras[c].cam_from_world = given_.truth.cameras[c].cam_from_world;
  }
  const Rigid3 kick{Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Vector3d::UnitY())), {0.05, 0, 0}};
  given_.seen.cameras[2].cam_from_world = kick * given_.seen.cameras[2].cam_from_world;
  turn_the_world();
  ASSERT_THAT(set(OwnGauge{}), IsOk());
  for (const std::size_t c : {0u, 1u, 3u}) {
    const Rigid3 &is = given_.scene.cameras[c].cam_from_world, &was = given_.truth.cameras[c].cam_from_world;
    EXPECT_LT((is.center() - was.center()).norm(), 1e-3) << c;
    EXPECT_LT(angle_between(is.rotation, was.rotation) * kDegrees, 0.03) << c;
  }
}

TEST_F(SetGauge, MovesTheCovarianceWithTheWorld) {
  Random random(7);
  const MatrixXd root = MatrixXd::NullaryExpr(rows(), rows(), [&] { return 1e-3 * random.normal(); });
  covariance_ = root * root.transpose();
  const Vector3d point(0.2, -0.1, 2.5);
  const Eigen::Matrix2d before = pixel_covariance(1, point);
  ASSERT_THAT(set(HandSet{.camera = 0, .cam_from_world = kElsewhere}), IsOk());
  EXPECT_LT((pixel_covariance(1, point) - before).norm(), 1e-6 * before.norm());
  EXPECT_LT((covariance_ - covariance_.transpose()).norm(), 1e-9 * covariance_.norm());
}

}  // namespace
}  // namespace floatstage::calib::solver
