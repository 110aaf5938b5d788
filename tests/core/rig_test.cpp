#include "core/rig.h"

#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "tests/core/rigs.h"
#include "tests/support/matchers.h"

namespace floatstage {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Rig, FindsCamerasBySerial) {
  EXPECT_EQ(camera_index(ring(4), "cam2"), 2);
  EXPECT_EQ(camera_index(ring(4), "cam"), -1);
}

TEST(Rig, OfAnyLensPassesItsCheck) {
  Rig rig = ring(3);
  rig.cameras[1].model.lens = BrownConrady{-0.2, 0.1, 0, 0, 0};
  rig.cameras[2].model.lens = KannalaBrandt{};
  EXPECT_THAT(check(rig), IsOk());
}

struct Fault {
  const char* name;
  std::function<void(RigCamera&)> make;
  const char* complaint;
};

class FaultyRig : public testing::TestWithParam<Fault> {};

TEST_P(FaultyRig, IsRefusedByACheckThatNamesTheCamera) {
  Rig rig = ring(3);
  GetParam().make(rig.cameras[1]);
  EXPECT_THAT(check(rig), FailsWith(ErrorCode::BadData, "camera '" + rig.cameras[1].serial + "'"));
  EXPECT_THAT(check(rig), FailsWith(ErrorCode::BadData, GetParam().complaint));
}

INSTANTIATE_TEST_SUITE_P(
    Faults, FaultyRig,
    testing::Values(
        Fault{"NanFocal", [](RigCamera& c) { c.model.fx = kNaN; }, "not a finite number"},
        Fault{"InfiniteCentre", [](RigCamera& c) { c.model.cy = kInfinity; }, "not a finite number"},
        Fault{"NanSkew", [](RigCamera& c) { c.model.skew = kNaN; }, "not a finite number"},
        Fault{"ZeroFocal", [](RigCamera& c) { c.model.fy = 0; }, "not positive"},
        Fault{"NoSize", [](RigCamera& c) { c.model.width = 0; }, "image size 0x480"},
        Fault{"NanBrown",
              [](RigCamera& c) {
                c.model.lens = BrownConrady{0, 0, kNaN, 0, 0};
              },
              "lens coefficient"},
        Fault{"InfiniteFisheye",
              [](RigCamera& c) {
                c.model.lens = KannalaBrandt{0, 0, 0, -kInfinity};
              },
              "lens coefficient"},
        Fault{"NanRotation", [](RigCamera& c) { c.cam_from_world.rotation.x() = kNaN; }, "not finite"},
        Fault{"NanPlace", [](RigCamera& c) { c.cam_from_world.translation.z() = kNaN; }, "not finite"},
        Fault{"LongRotation", [](RigCamera& c) { c.cam_from_world.rotation.coeffs() *= 1.001; },
              "unit length"},
        Fault{"NanColour", [](RigCamera& c) { c.color.matrix(1, 1) = kNaN; }, "colour matrix"},
        Fault{"NoSerial", [](RigCamera& c) { c.serial.clear(); }, "a serial must be"},
        Fault{"HiddenSerial", [](RigCamera& c) { c.serial = ".left"; }, "a serial must be"},
        Fault{"PathSerial", [](RigCamera& c) { c.serial = "a/b"; }, "a serial must be"},
        Fault{"AccentSerial", [](RigCamera& c) { c.serial = "caf\xc3\xa9"; }, "a serial must be"},
        Fault{"TwiceTheSerial", [](RigCamera& c) { c.serial = "cam0"; }, "two cameras"}),
    [](const auto& p) { return p.param.name; });

TEST(Rig, WithoutCamerasIsRefused) { EXPECT_THAT(check(Rig{}), FailsWith(ErrorCode::BadData, "no camera")); }

TEST(FocusPoint, IsWhereTheAxesMeet) {
  EXPECT_LT((focus_point(ring(8)) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);
}

TEST(FocusPoint, OfTwoCamerasThatFaceEachOtherIsBetweenThem) {
  EXPECT_LT((focus_point(ring(2)) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);
}

TEST(FocusPoint, OfSkewAxesIsHalfWayBetweenThem) {
  Rig rig = ring(1);
  rig.cameras[0].cam_from_world = look_at({-2, 0, 0.5}, {0, 0, 0.5}, {0, 0, 1});  // along x at z = 0.5
  rig.cameras.push_back(rig.cameras[0]);
  rig.cameras[1].cam_from_world = look_at({0, -2, 1.5}, {0, 0, 1.5}, {0, 0, 1});  // along y at z = 1.5
  EXPECT_LT((focus_point(rig) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);
}

TEST(FocusPoint, OfParallelAxesLiesAheadOfTheRig) {
  Rig rig = ring(1);
  rig.cameras.assign(3, rig.cameras[0]);
  for (int i = 0; i < 3; ++i)
    rig.cameras[i].cam_from_world = look_at({2.0 * i, 0, 1}, {2.0 * i, 5, 1}, {0, 0, 1});
  EXPECT_LT((focus_point(rig) - Eigen::Vector3d(2, 2, 1)).norm(), 1e-9)
      << "the centroid, moved by the spread of 2 m";
}

TEST(FocusPoint, OfOneCameraLiesAheadOfIt) {
  const Rig rig = ring(1);
  EXPECT_LT((focus_point(rig) - Eigen::Vector3d(2, 0, 1)).norm(), 1e-9);
}

TEST(MeanUp, IsTheWorldsUpForLevelCameras) {
  EXPECT_LT((mean_up(ring(5)) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(MeanUp, FollowsATiltedWorld) {
  Rig rig = ring(5);
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  for (RigCamera& c : rig.cameras)
    c.cam_from_world = c.cam_from_world * Rigid3{tilt.conjugate(), Eigen::Vector3d::Zero()};
  EXPECT_LT((mean_up(rig) - tilt * Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(MeanUp, OfCamerasThatDisagreeEntirelyIsUp) {
  Rig rig = ring(1);
  rig.cameras.push_back(rig.cameras[0]);
  rig.cameras[1].cam_from_world = look_at({3, 0, 1}, {0, 0, 1}, {0, 0, -1});
  EXPECT_EQ(mean_up(rig), Eigen::Vector3d::UnitZ());
}

}  // namespace
}  // namespace floatstage
