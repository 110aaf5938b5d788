// A turntable's ring as a soft prior.
#include "calib/solver/ring.h"

#include <cmath>
#include <numbers>

#include "calib/calibrate.h"
#include "calib/scene_features.h"
#include "calib/scene_settling.h"
#include "core/random.h"
#include "core/text.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

using Eigen::Vector3d;

constexpr int kCameras = 12, kBare = 5;
constexpr double kRadius = 2;

Rigid3 looking_at_origin(const Vector3d& center) {
  const Vector3d forward = -center.normalized(), right = forward.cross(Vector3d::UnitZ()).normalized(),
                 down = forward.cross(right);
  Eigen::Matrix3d rows;
  rows << right.transpose(), down.transpose(), forward.transpose();
  return {Eigen::Quaterniond(rows), -(rows * center)};
}

// Cameras on a circle; `off`: that much of the radius one of them stands beside it.
Rig ring_of_cameras(double off = 0) {
  Rig rig;
  for (int i = 0; i < kCameras; ++i) {
    const double a = 2 * std::numbers::pi * i / kCameras, r = kRadius * (i == kBare ? 1 + off : 1);
    RigCamera c;
    c.serial = text("cam", i);
    c.model = {.width = 640, .height = 480, .fx = 800, .fy = 800, .cx = 320, .cy = 240, .lens = {}};
    c.cam_from_world = looking_at_origin({r * std::cos(a), r * std::sin(a), 0.5});
    rig.cameras.push_back(c);
  }
  return rig;
}

// Points that all cameras see to half a pixel, of which one camera sees `of_bare` only.
Observations observations_of(const Rig& rig, int of_bare, std::uint64_t seed) {
  Random random(seed);
  Observations o;
  std::vector<int> camera_of;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    CalibrationCamera c;
    c.serial = rig.cameras[i].serial;
    c.width = 640;
    c.height = 480;
    c.lens = LensKind::None;
    c.intrinsics = Prior::Fixed;
    c.model = rig.cameras[i].model;
    c.found = rig.cameras[i].cam_from_world;
    c.found->translation += 0.01 * Vector3d(random.normal(), random.normal(), random.normal());
    o.cameras.push_back(c);
    camera_of.push_back(static_cast<int>(i));
  }
  std::vector<SceneFeature> features;
  for (int k = 0; k < 80; ++k) {
    SceneFeature f;
    f.position = 0.3 * Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    for (int i = 0; i < kCameras; ++i) {
      if (i == kBare && k >= of_bare) continue;
      const RigCamera& c = rig.cameras[static_cast<std::size_t>(i)];
      f.seen.emplace_back(i, *project(c.model, c.cam_from_world * f.position) +
                                 0.5 * Eigen::Vector2d(random.normal(), random.normal()));
    }
    features.push_back(f);
  }
  const double apart =
      (rig.cameras[0].cam_from_world.center() - rig.cameras[6].cam_from_world.center()).norm();
  o.distances.push_back({0, 6, apart, 1e-4 * apart});
  add_features(o, features, camera_of);
  return o;
}

// How far the bare camera is from where it stands seen from two others, metres.
double off_place(const Rig& found, const Rig& truth) {
  double sum = 0;
  for (const std::size_t other : {std::size_t{0}, std::size_t{2}, std::size_t{8}}) {
    const auto apart = [&](const Rig& rig) {
      return (rig.cameras[kBare].cam_from_world.center() - rig.cameras[other].cam_from_world.center()).norm();
    };
    sum += std::abs(apart(found) - apart(truth));
  }
  return sum / 3;
}

double error_of(const Rig& rig, int of_bare, double ring, std::uint64_t seed) {
  const Result<Calibration> solved =
      calibrate(observations_of(rig, of_bare, seed), {.holdout_every = 0, .threads = 1, .ring = ring});
  EXPECT_THAT(solved, IsOk());
  return solved ? off_place(solved->rig, rig) : 1;
}

TEST(Ring, OfPointsOnACircleIsThatCircle) {
  std::vector<Vector3d> points;
  const Eigen::Quaterniond turn(0.8, 0.1, -0.5, 0.3);
  for (const double a : {0.1, 0.9, 1.4, 2.2, 2.9})
    points.push_back(turn.normalized() * Vector3d(3 * std::cos(a), 3 * std::sin(a), 0) + Vector3d(1, 2, 3));
  const std::optional<solver::Ring> ring = solver::fit_ring(points);
  ASSERT_TRUE(ring);
  EXPECT_NEAR(ring->radius, 3, 1e-9);
  EXPECT_LE((ring->center - Vector3d(1, 2, 3)).norm(), 1e-9);
  for (const Vector3d& p : points) EXPECT_LE(ring->off(p).norm(), 1e-9);
  EXPECT_NEAR(ring->off(ring->center + ring->axis)[0], 1, 1e-9);
}

TEST(Ring, NeedsFourPointsThatAreNotInLine) {
  EXPECT_FALSE(solver::fit_ring(std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_FALSE(solver::fit_ring(std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}));
  EXPECT_FALSE(solver::fit_ring(std::vector<Vector3d>(6, Vector3d(1, 1, 1))));
}

TEST(Ring, HoldsACameraThatFewPointsTie) {
  const Rig rig = ring_of_cameras();
  double alone = 0, held = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    alone += error_of(rig, 5, 0, seed) / 3;
    held += error_of(rig, 5, 1e-3, seed) / 3;
  }
  RecordProperty("alone_mm", text(1e3 * alone));
  std::printf("one camera of %d sees 5 points: %.2f mm off alone, %.2f mm on the ring\n", kCameras,
              1e3 * alone, 1e3 * held);
  EXPECT_LE(held, 0.5 * alone);
}

TEST(Ring, LeavesCamerasThatManyPointsTieWhereTheseSay) {
  const Rig rig = ring_of_cameras();
  EXPECT_NEAR(error_of(rig, 80, 1e-2, 1), error_of(rig, 80, 0, 1), 2e-4);
}

TEST(Ring, ThatIsNoneIsRefusedByTheCameraThatStandsBesideIt) {
  const Rig rig = ring_of_cameras(0.15);
  const Result<Calibration> solved =
      calibrate(observations_of(rig, 80, 1), {.holdout_every = 0, .threads = 1, .ring = 1e-2});
  ASSERT_THAT(solved, IsOk());
  std::vector<MarkerlessPicture> pictures;
  for (const RigCamera& c : rig.cameras)
    pictures.push_back({.serial = c.serial, .file = {}, .model = c.model, .pixels = {}});
  MarkerlessResult result;
  result.rig = solved->rig;
  EXPECT_THAT(check_ring(pictures, {.ring = 1e-2}, result), FailsWith(ErrorCode::BadData, "'cam5'"));
  EXPECT_THAT(check_ring(pictures, {.ring = 0.1}, result), IsOk());
  ASSERT_TRUE(result.off_ring);
  EXPECT_NEAR(*result.off_ring, 0.04, 0.03);
  MarkerlessResult nobody_asks;
  nobody_asks.rig = solved->rig;
  EXPECT_THAT(check_ring(pictures, {}, nobody_asks), IsOk());
  EXPECT_FALSE(nobody_asks.off_ring);
}

TEST(Ring, IsAShareOfItsRadius) {
  const Observations o = observations_of(ring_of_cameras(), 80, 1);
  for (const double ring : {-0.1, 1e-6, 0.5, std::nan("")})
    EXPECT_THAT(calibrate(o, {.ring = ring}), FailsWith(ErrorCode::InvalidArgument, "ring")) << ring;
}

}  // namespace
}  // namespace floatstage::calib
