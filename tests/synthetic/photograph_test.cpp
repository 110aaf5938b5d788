#include "core/synthetic/photograph.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

RigCamera camera_with(Lens lens, int width = 160, int height = 120) {
  RigCamera camera = synthetic_rig({.cameras = 3, .width = width, .height = height}).cameras[1];
  camera.model.lens = lens;
  return camera;
}

class EveryLens : public testing::TestWithParam<Lens> {};

TEST_P(EveryLens, TracesTheRaysThatTheCameraModelProjects) {
  const RigCamera camera = camera_with(GetParam());
  const TracingCamera tracing(camera.model, camera.cam_from_world);
  EXPECT_LT((tracing.center().cast<double>() - camera.cam_from_world.center()).norm(), 1e-6);
  for (int y = 0; y < 120; y += 17) {
    for (int x = 0; x < 160; x += 13) {
      for (const Vector2d& in_pixel : {Vector2d(0.5, 0.5), Vector2d(0.1, 0.8)}) {
        const Vector3f d =
            tracing.direction(x, y, static_cast<float>(in_pixel.x()), static_cast<float>(in_pixel.y()));
        const Vector3d in_camera =
            camera.cam_from_world * (camera.cam_from_world.center() + 2.5 * d.cast<double>());
        EXPECT_NEAR(in_camera.z(), 2.5, 1e-5) << "the ray's parameter is depth";
        const auto pixel = project(camera.model, in_camera);
        ASSERT_TRUE(pixel);
        EXPECT_LT((*pixel - Vector2d(x, y) - in_pixel).norm(), 2e-3);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, EveryLens,
                         testing::Values(Lens{}, Lens{BrownConrady{.k1 = -0.2, .k2 = 0.05}},
                                         Lens{KannalaBrandt{.k1 = 0.02}}));

TEST(TracingCamera, HasNoRayWhereTheLensHasNone) {
  RigCamera camera = camera_with(BrownConrady{.k1 = -0.9});
  camera.model.fx = camera.model.fy = 60;  // so wide that the corners lie beyond the lens' turning point
  const TracingCamera tracing(camera.model, camera.cam_from_world);
  EXPECT_TRUE(std::isnan(tracing.direction(0, 0, 0.5f, 0.5f).x()));
  EXPECT_TRUE(tracing.direction(80, 60, 0.5f, 0.5f).allFinite());
  const Image plate = photograph_room(tracing, Room({{camera}}, SyntheticStage::Green, 1));
  EXPECT_EQ(plate.at(0, 0)[1], 0) << "black, as in a picture of a lens that does not fill it";
  EXPECT_GT(plate.at(80, 60)[1], 60);
}

// One scene for the tests below.
class APhotograph : public testing::Test {
 protected:
  const Device device{rtcNewDevice("threads=1")};
  const Performer performer{3};
  const StageScene scene{device.get(), performer, 0.5};
  const RigCamera camera = camera_with({});
  const TracingCamera tracing{camera.model, camera.cam_from_world};
  const Image grey{160, 120, 3, 100};

  Exposure at(int across, float spill = 0) const {
    return photograph(tracing, scene, grey, {.samples_across = across, .spill = spill, .seed = 1});
  }
};

TEST_F(APhotograph, HasAsManyLevelsOfCoverageAsRaysInAPixel) {
  for (int across : {1, 2, 3}) {
    const Exposure exposure = at(across);
    const std::set<std::uint8_t> levels(exposure.alpha.begin(), exposure.alpha.end());
    EXPECT_LE(levels.size(), static_cast<std::size_t>(across * across + 1));
    EXPECT_GE(levels.size(), static_cast<std::size_t>(across * across)) << "and uses them";
  }
}

TEST_F(APhotograph, ConvergesWithTheNumberOfRays) {
  const Exposure fine = at(10);
  auto distance = [&](const Exposure& e) {
    double sum = 0;
    for (std::size_t i = 0; i < fine.color.size(); ++i)
      sum += (e.color[i] - fine.color[i]).cast<double>().squaredNorm();
    return std::sqrt(sum);
  };
  const double one = distance(at(1)), nine = distance(at(3)), sixteen = distance(at(4));
  EXPECT_LT(nine, 0.4 * one);
  EXPECT_LT(sixteen, nine);
}

TEST_F(APhotograph, MixesThePlateInByCoverage) {
  const Image white(160, 120, 3, 255), black(160, 120, 3, 0);
  const Exposure on_white = photograph(tracing, scene, white, {.samples_across = 3}),
                 on_black = photograph(tracing, scene, black, {.samples_across = 3});
  EXPECT_EQ(on_white.alpha, on_black.alpha);
  for (std::size_t i = 0; i < on_white.color.size(); ++i) {
    // The difference of the two backgrounds shows through by 1 - alpha: how mattes are measured in film.
    const float through = (on_white.color[i] - on_black.color[i]).mean();
    ASSERT_NEAR(1 - through, static_cast<float>(on_white.alpha[i]) / 255, 0.003);
  }
}

TEST_F(APhotograph, IsLitFromAboveAndNeverBlack) {
  const Exposure exposure = at(3);
  double darkest = 1;
  for (std::size_t i = 0; i < exposure.color.size(); ++i) {
    if (exposure.alpha[i] < 255) continue;
    ASSERT_TRUE(exposure.color[i].allFinite());
    darkest = std::min<double>(darkest, exposure.color[i].maxCoeff());
    EXPECT_LE(exposure.color[i].maxCoeff(), 1.0f);
  }
  EXPECT_GT(darkest, 0.02);
}

TEST_F(APhotograph, IsGreenerWithSpillButNowhereDarker) {
  const Exposure clean = at(2), spilled = at(2, 1);
  for (std::size_t i = 0; i < clean.color.size(); ++i) {
    ASSERT_GE(spilled.color[i].minCoeff() - clean.color[i].minCoeff(), -1e-6f);
    if (clean.alpha[i] == 0) {
      ASSERT_EQ(spilled.color[i], clean.color[i]);
    }
  }
}

TEST_F(APhotograph, ShowsTheSamePerformerThroughAPictureTwiceAsLarge) {
  const RigCamera big = camera_with({}, 320, 240);
  const Exposure large = photograph(TracingCamera(big.model, big.cam_from_world), scene,
                                    Image(320, 240, 3, 100), {.samples_across = 2});
  const Exposure small =
      at(4);  // the same rays, gathered four pixels at a time, but for their places in the cell
  double coverage_large = 0, coverage_small = 0;
  for (std::uint8_t a : large.alpha) coverage_large += a / 255.0 / 4;
  for (std::uint8_t a : small.alpha) coverage_small += a / 255.0;
  EXPECT_NEAR(coverage_large / coverage_small, 1, 0.003);
}

TEST(Room, IsSeenFromInsideInEveryDirection) {
  const Rig rig = synthetic_rig({.cameras = 4});
  const Room room(rig, SyntheticStage::Green, 1);
  for (float x : {-1.0f, -0.3f, 0.0f, 0.4f, 1.0f})
    for (float y : {-1.0f, 0.0f, 0.7f})
      for (float z : {-1.0f, 0.0f, 1.0f}) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vector3f c = room.color({0, 0, 1}, {x, y, z});
        EXPECT_GT(c.y(), 0.25f);
        EXPECT_LT(c.maxCoeff(), 1.0f);
      }
}

TEST(Room, HoldsEveryCameraOfARigHoweverWide) {
  const Rig rig = synthetic_rig({.cameras = 4, .distance = 12, .height_above_floor = 6});
  const Room room(rig, SyntheticStage::Green, 1);
  for (const RigCamera& c : rig.cameras) {
    const Vector3f from = c.cam_from_world.center().cast<float>();
    EXPECT_GT(room.color(from, -from).y(), 0.1f);
    EXPECT_GT(room.color(from, from).y(), 0.1f) << "there is cloth behind the camera too";
  }
}

TEST(Room, HidesNothingFromACameraOutsideIt) {
  const Room room(synthetic_rig({.cameras = 4}), SyntheticStage::Green, 1);
  EXPECT_GT(room.color({20, 0, 1}, {-1, 0, 0}).y(), 0.2f) << "the near wall is open, the far one is seen";
  EXPECT_EQ(room.color({20, 0, 1}, {1, 0, 0}), Vector3f(0, 0, 0)) << "nothing behind it";
}

}  // namespace
}  // namespace floatstage::synthetic
