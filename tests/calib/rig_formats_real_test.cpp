#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "tests/calib/format_support.h"

namespace floatstage {
namespace {

using Eigen::Vector3d;

std::filesystem::path data(const std::string& name) { return std::filesystem::path(FLOATSTAGE_DATA_DIR) / name; }

// Real data may be absent on a laptop, never in the checks that guard the main branch.
#define NEEDS_DATA(folder)                                                                          \
  do {                                                                                              \
    const char* ci = std::getenv("CI");                                                             \
    if (!std::filesystem::exists(folder)) {                                                         \
      if (ci != nullptr && std::string(ci) == "true") FAIL() << folder << " is missing";            \
      GTEST_SKIP() << folder << " is not on this machine";                                          \
    }                                                                                               \
  } while (false)

void expect_temple(const std::string& file, std::size_t cameras, const Eigen::AlignedBox3d& box) {
  const Result<ForeignRig> foreign = read_middlebury(data(file));
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
  NEEDS_DATA(data("middlebury-temple-ring"));
  expect_temple("middlebury-temple-ring/templeR_par.txt", 47,
                {Vector3d(-0.023121, -0.038009, -0.091940), Vector3d(0.078626, 0.121636, -0.017395)});
}

TEST(MiddleburyReal, TempleSparseRingLooksAtTheTemple) {
  NEEDS_DATA(data("middlebury-temple-sparse-ring"));
  expect_temple("middlebury-temple-sparse-ring/templeSR_par.txt", 16,
                {Vector3d(-0.073568, 0.021728, -0.012445), Vector3d(0.028855, 0.181892, 0.062736)});
}

TEST(DomeReal, TwentyCamerasStandOnARingEighteenDegreesApart) {
  NEEDS_DATA(data("green-dome"));
  const Result<ForeignRig> foreign = read_dome(data("green-dome/calibration.txt"), 0.1);
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
    const Vector3d here = on_floor(rig.cameras[i]), there = on_floor(rig.cameras[(i + 1) % rig.cameras.size()]);
    const double degrees = std::acos(here.normalized().dot(there.normalized())) * 180 / std::numbers::pi;
    EXPECT_NEAR(degrees, 18, 4) << "from camera " << i << " to the next";
    turned += degrees;
    const RigCamera& c = rig.cameras[i];
    const Vector3d in_camera = c.cam_from_world * focus;
    EXPECT_LT(std::atan2(in_camera.head<2>().norm(), in_camera.z()) * 180 / std::numbers::pi, 10) << c.serial;
  }
  EXPECT_NEAR(turned, 360, 8);
}

}  // namespace
}  // namespace floatstage
