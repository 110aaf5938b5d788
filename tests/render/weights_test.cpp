#include <map>

#include <gtest/gtest.h>

#include "render/camera_choice.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

std::vector<Eigen::Vector3f> samples_of(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> samples;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 7) samples.push_back(mesh.positions[i]);
  return samples;
}

CameraChoice chosen(const Rig& rig, double degrees, int count) {
  CameraRanking memory;
  return choose_cameras(rig.cameras, samples_of(ball(0.25F, 12)), view_at(degrees), count, {}, memory);
}

TEST(CameraChoice, TakesTheNearestCamerasNearestFirst) {
  const CameraChoice choice = chosen(arc(8, 20), 13, 3);  // cameras stand at -70, -50 … 70
  ASSERT_EQ(choice.chosen, 3U);
  EXPECT_THAT(std::vector<int>(choice.listed.begin(), choice.listed.begin() + 3),
              testing::ElementsAre(4, 5, 3));
}

TEST(CameraChoice, KeepsFurtherCamerasInReserve) {
  const CameraChoice choice = chosen(arc(8, 20), 13, 3);
  EXPECT_GT(choice.listed.size(), choice.chosen);
  for (std::size_t i = choice.chosen; i < choice.listed.size(); ++i)
    EXPECT_EQ(choice.fade[i], 0) << "camera " << i;
}

TEST(CameraChoice, UsesAllCamerasWhenThereAreFewerThanAsked) {
  const CameraChoice choice = chosen(arc(2, 20), 3, 3);
  EXPECT_EQ(choice.chosen, 2U);
  for (const float fade : choice.fade) EXPECT_EQ(fade, 1);
}

// Along a path each camera's share changes little from step to step, also where one camera replaces another.
TEST(CameraChoice, SharesAreContinuousAlongAPath) {
  const Rig rig = arc(8, 20);
  constexpr double kStep = 0.05;  // degrees
  auto shares = [&](double degrees) {
    const CameraChoice choice = chosen(rig, degrees, 3);
    std::map<int, double> share;
    double sum = 0;
    for (std::size_t i = 0; i < choice.chosen; ++i) sum += choice.fade[i];
    for (std::size_t i = 0; i < choice.chosen; ++i) share[choice.listed[i]] = choice.fade[i] / sum;
    return share;
  };
  std::map<int, double> before = shares(-30);
  int changes_of_set = 0;
  for (double degrees = -30 + kStep; degrees < 30; degrees += kStep) {
    std::map<int, double> now = shares(degrees);
    for (int camera = 0; camera < 8; ++camera)
      ASSERT_NEAR(now.count(camera) ? now[camera] : 0, before.count(camera) ? before[camera] : 0, 0.02)
          << "camera " << camera << " at " << degrees;
    for (const auto& [camera, share] : now) changes_of_set += before.count(camera) == 0;
    before = now;
  }
  EXPECT_GE(changes_of_set, 3) << "the path does not cross from camera to camera";
}

TEST(CameraChoice, EqualAnglesAreOrderedByPlaceNotByNumber) {
  Rig rig = arc(4, 20);
  const CameraChoice forward_order = chosen(rig, 0, 2);
  std::reverse(rig.cameras.begin(), rig.cameras.end());
  const CameraChoice backward = chosen(rig, 0, 2);
  ASSERT_EQ(forward_order.listed.size(), backward.listed.size());
  for (std::size_t i = 0; i < backward.listed.size(); ++i)
    EXPECT_EQ(forward_order.listed[i], 3 - backward.listed[i]);
}

class Weights : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(Weights);

// Photographs of one colour: whatever the weights, they must sum to one for the colour to come out.
TEST_P(Weights, SumToOneEverywhere) {
  Stage stage = photographed(arc(6, 25), ball(0.25F, 24, 0.5F), ball(0.25F, 24, 0.5F), false);
  for (Frame& frame : stage.scene.images.frames) {
    Image flat(160, 120, 3);
    for (std::size_t i = 0; i < flat.pixels.size(); i += 3) {
      flat.pixels[i] = 200;
      flat.pixels[i + 1] = 100;
      flat.pixels[i + 2] = 50;
    }
    frame = make_frame(frame.info, flat);
  }
  for (const char* method : {"nearest", "linear", "floating"}) {
    const Image picture = rendered(stage, view_at(8, 40), method);
    int covered = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
      if (picture.pixels[i + 3] == 0) continue;
      ++covered;
      ASSERT_EQ(picture.pixels[i], 200) << method;
      ASSERT_EQ(picture.pixels[i + 1], 100) << method;
      ASSERT_EQ(picture.pixels[i + 2], 50) << method;
    }
    EXPECT_GT(covered, 1000);
  }
}

// A small step of the view changes every pixel of a smooth scene little, also while cameras are exchanged.
TEST_P(Weights, PicturesAreContinuousAlongAPath) {
  Stage stage = photographed(arc(6, 20), ball(0.25F, 48), ball(0.25F, 48), false);
  for (std::size_t c = 0; c < 6; ++c) {  // one grey a camera: the picture shows the weights
    const Image flat(160, 120, 3, static_cast<std::uint8_t>(40 * c + 20));
    stage.scene.images.frames[c] = make_frame(stage.scene.images.frames[c].info, flat);
  }
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const auto renderer = make("linear");
  Image before;
  for (double degrees = -12; degrees <= 12; degrees += 0.25) {
    const auto picture = renderer->render(scene, view_at(degrees), {});
    ASSERT_THAT(picture, IsOk());
    const Image now = download(*picture);
    for (int y = 50; y < 70 && !before.empty(); ++y)
      for (int x = 60; x < 100; ++x) ASSERT_NEAR(now.at(x, y)[0], before.at(x, y)[0], 6) << "at " << degrees;
    before = now;
  }
}

}  // namespace
}  // namespace floatstage::render
