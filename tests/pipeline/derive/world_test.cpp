#include "pipeline/world.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"
#include "pipeline/derive/sightings.h"
#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::Not;

// A studio's rig as another program might state it: turned, moved, in units of `unit` metres.
WorldChange foreign(double unit) {
  return {1 / unit, Eigen::Quaterniond(Eigen::AngleAxisd(2, Vector3d(0.36, 0.48, 0.8))), {3, -2, 0.5}};
}

Rig studio() { return synthetic_rig({}); }

std::vector<Sighting> marks(const Rig& rig, const Vector3d& point, std::vector<int> cameras) {
  std::vector<Sighting> out;
  for (const int c : cameras) {
    const RigCamera& camera = rig.cameras[static_cast<std::size_t>(c)];
    out.push_back({c, *project(camera.model, camera.cam_from_world * point)});
  }
  return out;
}

TEST(World, ThatIsAnotherOneShowsTheSamePictures) {
  const Rig rig = studio();
  const WorldChange change = foreign(0.1);
  const Rig moved = in_world(rig, change);
  for (const Vector3d& p : {Vector3d(0.3, -0.2, 1.1), Vector3d(0, 0.4, 0.2)})
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      const auto before = project(rig.cameras[c].model, rig.cameras[c].cam_from_world * p);
      const auto after = project(moved.cameras[c].model, moved.cameras[c].cam_from_world * (change * p));
      EXPECT_LT((*before - *after).norm(), 1e-9);
    }
}

TEST(World, IsTurnedByTheCamerasRing) {
  const Rig lying = in_world(studio(), foreign(1));
  const Result<WorldChange> change = world_change(lying, {.up = "ring", .scale = {}, .floor = {}});
  ASSERT_THAT(change, IsOk());
  const Rig upright = in_world(lying, *change);
  EXPECT_GT(mean_up(upright).z(), 0.9);
  EXPECT_LT(focus_point(upright).head<2>().norm(), 0.05) << "the origin goes below the ring's middle";
  EXPECT_THAT(describe_world(lying), HasSubstr("--up ring"));
  EXPECT_THAT(describe_world(upright), Not(HasSubstr("--up ring")));
}

TEST(World, IsTurnedByAnAxisScaledAndLowered) {
  const Rig rig = studio();
  const Result<WorldChange> change = world_change(rig, {.up = "-y", .scale = 2, .floor = -3});
  ASSERT_THAT(change, IsOk());
  EXPECT_LT((*change * Vector3d(0, -1, 0) - Vector3d(0, 0, 5)).norm(), 1e-12);
  EXPECT_LT((world_change(rig, {.up = "z", .scale = {}, .floor = {}})->rotation.vec()).norm(), 1e-12);
  for (const double nonsense : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THAT(world_change(rig, {.up = "", .scale = nonsense, .floor = {}}),
                FailsWith(ErrorCode::InvalidArgument, "scale"));
}

TEST(Sightings, MeetInThePointThatWasMarked) {
  const Rig rig = studio();
  const Vector3d point(0.2, 0.1, 1.4);
  const Result<Placed> placed = place(rig, marks(rig, point, {0, 2, 5}), "the head");
  ASSERT_THAT(placed, IsOk());
  EXPECT_LT((placed->point - point).norm(), 1e-6);
  EXPECT_LT(placed->error, 1e-4);
}

TEST(Sightings, OfOneCameraOrOfDifferentThingsAreRefused) {
  const Rig rig = studio();
  EXPECT_THAT(place(rig, marks(rig, {0, 0, 1}, {3}), "the head"),
              FailsWith(ErrorCode::InvalidArgument, "the head"));
  std::vector<Sighting> two = marks(rig, {0, 0, 1}, {0, 2, 4});
  two[1].pixel.y() += 80;
  EXPECT_THAT(place(rig, two, "the head"), FailsWith(ErrorCode::InvalidArgument, "mark it again"));
}

// A board on the floor before three cameras, in a take of a rig whose world is another one.
TEST(Sightings, OfABoardOnTheFloorGiveUpFloorAndScale) {
  const calib::TargetDesign board =
      *calib::parse_target("charuco columns=6 rows=5 square=100mm marker=75mm dictionary=4x4_50");
  Rig rig;
  std::vector<Image> pictures;
  for (int i = 0; i < 3; ++i) {
    const double a = 0.7 * i;
    RigCamera c{"c" + std::to_string(i), test::simple_camera(640, 480, 50), {}, {}};
    c.cam_from_world =
        look_at({0.3 + 1.2 * std::cos(a), 0.25 + 1.2 * std::sin(a), 1}, {0.3, 0.25, 0}, {0, 0, 1});
    pictures.push_back(test::board_picture(board, c.model, c.cam_from_world));
    rig.cameras.push_back(c);
  }
  TempFolder folder;
  const Rig lying = in_world(rig, foreign(0.1));
  auto writer = capture::TakeWriter::create(folder / "take", lying, {});
  ASSERT_THAT(writer, IsOk());
  for (int i = 0; i < 3; ++i) {
    FrameInfo info;
    info.camera = i;
    ASSERT_THAT((*writer)->write(make_frame(info, pictures[static_cast<std::size_t>(i)])), IsOk());
  }
  ASSERT_THAT((*writer)->finish(), IsOk());
  const auto take = std::move(*capture::TakeReader::open(folder / "take"));
  const Result<BoardWorld> world = world_from_board(*take, board, 0, 0.02);
  ASSERT_THAT(world, IsOk());
  EXPECT_EQ(world->cameras, 3);
  EXPECT_NEAR(world->change.scale, 0.1, 1e-4);
  EXPECT_LT(world->rms, 5e-4);
  const Rig upright = in_world(lying, world->change);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LT((upright.cameras[i].cam_from_world.center() - rig.cameras[i].cam_from_world.center() -
               Vector3d(0, 0, 0.02))
                  .norm(),
              3e-3)
        << "the board lies two centimetres above the floor";
  const calib::TargetDesign other =
      *calib::parse_target("charuco columns=6 rows=5 square=100mm marker=75mm dictionary=6x6_50");
  EXPECT_THAT(world_from_board(*take, other, 0, 0),
              FailsWith(ErrorCode::BadData, "0 cameras found the board"));
}

}  // namespace
}  // namespace floatstage::pipeline
