#include "render/camera_grid.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "tests/support/camera_grids.h"
#include "tests/support/matchers.h"

namespace floatstage::render {
namespace {

using testing::ElementsAre;

TEST(CameraGrid, FindsRowsAndColumnsInWhateverOrderCamerasCome) {
  std::vector<RigCamera> cameras = camera_wall(2, 3).cameras;
  std::swap(cameras[0], cameras[5]);
  const Result<CameraGrid> grid = camera_grid(cameras);
  ASSERT_THAT(grid, IsOk());
  EXPECT_EQ(grid->rows, 2);
  EXPECT_EQ(grid->columns, 3);
  EXPECT_THAT(grid->cameras, ElementsAre(5, 1, 2, 3, 4, 0));
  EXPECT_NEAR(grid->x[2] - grid->x[0], 0.2, 1e-9);
  EXPECT_NEAR(grid->y[1] - grid->y[0], 0.1, 1e-9);
  EXPECT_NEAR((grid->normal() - Eigen::Vector3d::UnitY()).norm(), 0, 1e-9) << "where the cameras look";
}

TEST(CameraGrid, BearsUnevenRowsAndCamerasThatStandAPitchsTenthOff) {
  std::vector<RigCamera> cameras = camera_wall(3, 3).cameras;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    Eigen::Vector3d at = cameras[i].cam_from_world.center();
    at += Eigen::Vector3d(i % 2 ? 0.01 : -0.01, i % 3 ? 0.005 : 0, i > 5 ? -0.05 : 0.01);
    cameras[i].cam_from_world = look_at(at, at + Eigen::Vector3d(0.05, 1, 0), {0, 0, 1});
  }
  const Result<CameraGrid> grid = camera_grid(cameras);
  ASSERT_THAT(grid, IsOk());
  EXPECT_EQ(grid->rows * grid->columns, 9);
}

TEST(CameraGrid, SaysWhyCamerasStandOnNone) {
  std::vector<RigCamera> cameras = camera_wall(3, 3).cameras;
  cameras.erase(cameras.begin() + 4);
  EXPECT_THAT(camera_grid(cameras), FailsWith(ErrorCode::InvalidArgument, "1 places have no camera"));
  EXPECT_THAT(camera_grid(camera_wall(1, 5).cameras), FailsWith(ErrorCode::InvalidArgument, "1 rows"));
  cameras.resize(3);
  EXPECT_THAT(camera_grid(cameras), FailsWith(ErrorCode::InvalidArgument, "only 3"));
  cameras = camera_wall(2, 2).cameras;
  cameras.push_back(cameras.front());
  EXPECT_THAT(camera_grid(cameras), FailsWith(ErrorCode::InvalidArgument, "one place"));
  cameras = camera_wall(2, 2).cameras;
  cameras[1].cam_from_world = look_at({0.05, -0.8, 0.05}, {0.05, 0, 0.05}, {0, 0, 1});
  EXPECT_THAT(camera_grid(cameras), FailsWith(ErrorCode::InvalidArgument, "before or behind"));
  EXPECT_THAT(camera_grid(std::vector<RigCamera>(4, cameras[0])),
              FailsWith(ErrorCode::InvalidArgument, "one place"));
}

}  // namespace
}  // namespace floatstage::render
