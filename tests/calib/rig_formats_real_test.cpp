#include <cmath>
#include <cstdlib>
#include <numbers>

#include <Eigen/Geometry>

#include "tests/calib/format_support.h"
#include "tests/support/real_data.h"

namespace floatstage::calib {
namespace {

using Eigen::Vector3d;

void expect_temple(const std::string& file, std::size_t cameras, const Eigen::AlignedBox3d& box) {
  const Result<ForeignRig> foreign = read_middlebury(real_data(file));
  ASSERT_TRUE(foreign.has_value()) << foreign.error().message;
  ASSERT_EQ(foreign->rig.cameras.size(), cameras);
  for (RigCamera c : foreign->rig.cameras) {
    c.model.width = 640;
    c.model.height = 480;
    const std::optional<Eigen::Vector2d> pixel = project(c.model, c.cam_from_world * box.center());
    ASSERT_TRUE(pixel.has_value()) << c.serial;
    EXPECT_TRUE(inside(c.model, *pixel)) << c.serial << ": " << pixel->transpose();
    EXPECT_NEAR((c.cam_from_world.center() - box.center()).norm(), 0.55, 0.1) << c.serial;
  }
  EXPECT_TRUE(box.contains(focus_point(foreign->rig))) << focus_point(foreign->rig).transpose();
}

TEST(MiddleburyReal, TempleRingLooksAtTheTemple) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  expect_temple("middlebury-temple-ring/templeR_par.txt", 47,
                {Vector3d(-0.023121, -0.038009, -0.091940), Vector3d(0.078626, 0.121636, -0.017395)});
}

TEST(MiddleburyReal, TempleSparseRingLooksAtTheTemple) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-sparse-ring"));
  expect_temple("middlebury-temple-sparse-ring/templeSR_par.txt", 16,
                {Vector3d(-0.073568, 0.021728, -0.012445), Vector3d(0.028855, 0.181892, 0.062736)});
}

TEST(DomeReal, TwentyCamerasStandOnARingEighteenDegreesApart) {
  FLOATSTAGE_NEEDS_DATA(real_data("green-dome"));
  const Result<ForeignRig> foreign = read_dome(real_data("green-dome/calibration.txt"), 0.1);
  ASSERT_TRUE(foreign.has_value()) << foreign.error().message;
  const Rig& rig = foreign->rig;
  ASSERT_EQ(rig.cameras.size(), 20u);
  EXPECT_EQ(rig.cameras[3].serial, "03");
  const Vector3d focus = focus_point(rig), up = mean_up(rig);
  double turned = 0;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const auto on_floor = [&](const RigCamera& c) -> Vector3d {
      const Vector3d v = c.cam_from_world.center() - focus;
      return v - up * up.dot(v);
    };
    const Vector3d here = on_floor(rig.cameras[i]),
                   there = on_floor(rig.cameras[(i + 1) % rig.cameras.size()]);
    const double degrees = std::acos(here.normalized().dot(there.normalized())) * 180 / std::numbers::pi;
    EXPECT_NEAR(degrees, 18, 4) << "from camera " << i << " to the next";
    turned += degrees;
    const RigCamera& c = rig.cameras[i];
    const Vector3d in_camera = c.cam_from_world * focus;
    EXPECT_LT(std::atan2(in_camera.head<2>().norm(), in_camera.z()) * 180 / std::numbers::pi, 10) << c.serial;
  }
  EXPECT_NEAR(turned, 360, 8);
}

// The four cameras of the balancing recording: serials cam01 … cam04.
Rig balancing_rig() {
  const Result<ForeignRig> foreign = read_qualisys(real_data("pose2sim-balancing/calibration/Calib.qca.txt"));
  EXPECT_TRUE(foreign.has_value()) << foreign.error().message;
  return foreign ? foreign->rig : Rig{};
}

// Nearest point to the rays through one pixel a camera; nullopt there is "not seen".
Vector3d triangulate(const Rig& rig, const std::vector<std::optional<Eigen::Vector2d>>& seen) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    const Rigid3& t = rig.cameras[i].cam_from_world;
    const Vector3d ray = (t.rotation.conjugate() * *unproject(rig.cameras[i].model, *seen[i])).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    a += across;
    b += across * t.center();
  }
  return a.inverse() * b;
}

// White marks on the platform that the person walks on, read by eye (to about half a pixel) in the four
// photographs of calibration/extrinsics, which show the same as the videos.
const std::vector<std::vector<std::optional<Eigen::Vector2d>>> kMarks{
    {{{110.1, 1061.4}}, {{442.6, 1041.9}}, {{873.7, 1234.8}}, {{836.8, 1410.8}}},
    {{{320.1, 1338.8}}, {{328.1, 1209.8}}, {{516.6, 1091.7}}, {{890.1, 1069.9}}},
    {{{521.9, 1065.1}}, {{795.9, 1085.5}}, {{485.7, 1432.0}}, {}},
    {{{773.3, 1293.6}}, {{764.1, 1271.9}}, {{165.1, 1240.7}}, {{519.9, 1117.3}}}};

double residual_of_marks(const Rig& rig) {
  double sum = 0;
  int count = 0;
  for (const auto& seen : kMarks) {
    const Vector3d mark = triangulate(rig, seen);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!seen[i]) continue;
      const std::optional<Eigen::Vector2d> pixel =
          project(rig.cameras[i].model, rig.cameras[i].cam_from_world * mark);
      sum += pixel ? (*pixel - *seen[i]).squaredNorm() : 1e6;
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(QualisysReal, FourCamerasHangAroundTheRoomAndLookAtThePerson) {
  FLOATSTAGE_NEEDS_DATA(real_data("pose2sim-balancing"));
  const Rig rig = balancing_rig();
  ASSERT_EQ(rig.cameras.size(), 4u);
  const Vector3d focus = focus_point(rig);
  EXPECT_LT((focus - Vector3d(-1, 0, 0.6)).norm(), 0.5) << focus.transpose();
  EXPECT_GT(mean_up(rig).z(), 0.95);
  for (const RigCamera& c : rig.cameras) {
    EXPECT_EQ(c.model.width, 1088);
    EXPECT_EQ(c.model.height, 1920);
    const Vector3d center = c.cam_from_world.center();
    EXPECT_GT(center.z(), 1.5) << c.serial;
    EXPECT_LT(center.z(), 2.5) << c.serial;
    EXPECT_GT((center - focus).head<2>().norm(), 2.5) << c.serial;
    const Vector3d in_camera = c.cam_from_world * focus;
    EXPECT_LT(std::atan2(in_camera.head<2>().norm(), in_camera.z()) * 180 / std::numbers::pi, 8) << c.serial;
  }
}

// This calibration is off by up to about 0.7 degrees in a camera: were every camera's principal point free,
// 0.44 px would be left. A wrong axis, unit or order of the rotation is off by hundreds.
TEST(QualisysReal, MarksOnThePlatformMeetAtItsSurface) {
  FLOATSTAGE_NEEDS_DATA(real_data("pose2sim-balancing"));
  const Rig rig = balancing_rig();
  ASSERT_EQ(rig.cameras.size(), 4u);
  EXPECT_LT(residual_of_marks(rig), 12);
  for (const auto& seen : kMarks) EXPECT_NEAR(triangulate(rig, seen).z(), 0, 0.01);
  const double length = (triangulate(rig, kMarks[1]) - triangulate(rig, kMarks[0])).norm();
  EXPECT_NEAR(length, 1.04, 0.03);
}

TEST(QualisysReal, MarksDoNotMeetUnderAnyOtherReadingOfTheRotation) {
  FLOATSTAGE_NEEDS_DATA(real_data("pose2sim-balancing"));
  const Rig rig = balancing_rig();
  ASSERT_EQ(rig.cameras.size(), 4u);
  for (const Eigen::Quaterniond& turn :
       {Eigen::Quaterniond(0, 1, 0, 0), Eigen::Quaterniond(0, 0, 1, 0), Eigen::Quaterniond(0, 0, 0, 1)}) {
    Rig other = rig;
    for (RigCamera& c : other.cameras) {
      const Vector3d center = c.cam_from_world.center();
      c.cam_from_world.rotation = turn * c.cam_from_world.rotation;
      c.cam_from_world.translation = c.cam_from_world.rotation * -center;
    }
    EXPECT_GT(residual_of_marks(other), 100);
  }
}

}  // namespace
}  // namespace floatstage::calib
