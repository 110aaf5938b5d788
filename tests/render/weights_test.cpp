#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "render/camera_choice.h"
#include "render/cpu/weight_kernels.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

RankingSamples samples_of(const Mesh& mesh) {
  RankingSamples samples;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 7)
    samples.push_back({mesh.positions[i], mesh.positions[i].normalized()});
  return samples;
}

CameraChoice chosen(const Rig& rig, double degrees, int count) {
  CameraRanking ranking(rig.cameras, samples_of(ball(0.25F, 12)));
  return choose_cameras(ranking, view_at(degrees), count, {});
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

TEST(CameraChoice, ListsNobodyWhereNobodyHasAPicture) {
  const Rig rig = arc(2, 20);
  CameraRanking ranking(rig.cameras, samples_of(ball(0.25F, 12)));
  const CameraChoice choice = choose_cameras(ranking, view_at(3), 3, {false, false});
  EXPECT_TRUE(choice.listed.empty());
  EXPECT_TRUE(choice.stand_in_fade.empty());
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

// A tall subject of which the cameras about the view have the lower half in their pictures: whoever has the
// upper half stands in for them, from wherever it is, and comes and goes by degrees.
Rig half_blind(int count) {
  Rig rig = arc(count, 20);
  for (int i = 0; i < count; ++i)
    if (i != 1 && i != 6)
      rig.cameras[static_cast<std::size_t>(i)].cam_from_world =
          look_at(rig.cameras[static_cast<std::size_t>(i)].cam_from_world.center(), {0, 0, -0.4}, {0, 0, 1});
  return rig;
}

TEST(CameraChoice, LetsThoseStandInThatHaveWhatTheChosenLack) {
  const CameraChoice choice = chosen(half_blind(8), 3, 3);  // among cameras 3 and 4
  ASSERT_EQ(choice.listed.size(), 6U);
  EXPECT_GT(choice.lacking, 0.1);
  EXPECT_THAT(std::vector<int>(choice.listed.begin() + 3, choice.listed.begin() + 5),
              testing::UnorderedElementsAre(1, 6));
  const float strongest = *std::max_element(choice.stand_in_fade.begin() + 3, choice.stand_in_fade.end());
  EXPECT_FLOAT_EQ(strongest, 1) << "it counts there as much as the nearest elsewhere";
  for (std::size_t i = 0; i < choice.listed.size(); ++i)
    EXPECT_GE(choice.stand_in_fade[i], choice.fade[i]) << "camera " << choice.listed[i];
}

TEST(CameraChoice, KeepsItsOrderWhereNothingIsMissing) {
  const CameraChoice choice = chosen(arc(8, 20), 3, 3);
  EXPECT_EQ(choice.lacking, 0);
  EXPECT_THAT(std::vector<int>(choice.listed.begin(), choice.listed.end()),
              testing::ElementsAre(4, 3, 5, 2, 6, 1));
}

TEST(CameraChoice, SharesOfThoseThatStandInAreContinuousAlongAPath) {
  const Rig rig = half_blind(8);
  auto shares = [&](double degrees) {
    const CameraChoice choice = chosen(rig, degrees, 3);
    std::map<int, double> share;
    double sum = 0;
    for (const float fade : choice.stand_in_fade) sum += fade;
    for (std::size_t i = 0; i < choice.listed.size(); ++i)
      share[choice.listed[i]] = choice.stand_in_fade[i] / sum;
    return share;
  };
  std::map<int, double> before = shares(-30);
  for (double degrees = -29.95; degrees < 30; degrees += 0.05) {
    std::map<int, double> now = shares(degrees);
    for (int camera = 0; camera < 8; ++camera)
      ASSERT_NEAR(now.count(camera) ? now[camera] : 0, before.count(camera) ? before[camera] : 0, 0.03)
          << "camera " << camera << " at " << degrees;
    before = now;
  }
}

// A dome of five by five cameras, 20 degrees apart, and what a view from (degrees, elevation) takes of it.
Rig dome() {
  Rig rig = arc(25, 1);
  for (int i = 0; i < 25; ++i)
    rig.cameras[static_cast<std::size_t>(i)].cam_from_world =
        on_orbit(20.0 * (i % 5 - 2), 20.0 * (i / 5 - 2));
  return rig;
}

CameraChoice chosen_of(const Rig& dome, double degrees, double elevation, int count) {
  CameraRanking ranking(dome.cameras, samples_of(ball(0.25F, 12)));
  return choose_cameras(ranking, view_at(degrees, elevation), count, {});
}

// In the middle of four cameras no three are the nearest: a hair's breadth must not say which.
TEST(CameraChoice, TakesMoreThanAskedWhereMoreAreAsNear) {
  const CameraChoice choice = chosen_of(dome(), 10, 10, 3);
  ASSERT_EQ(choice.chosen, 4U);
  std::vector<int> four(choice.listed.begin(), choice.listed.begin() + 4);
  std::sort(four.begin(), four.end());
  EXPECT_THAT(four, testing::ElementsAre(12, 13, 17, 18));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(choice.fade[i], choice.fade[0], 0.05) << "camera " << i;
}

TEST(CameraChoice, TakesAtMostTwiceAsManyAsAsked) {
  Rig rig = dome();
  std::erase_if(rig.cameras, [](const RigCamera& c) { return c.serial == "cam12"; });
  for (int count : {2, 3}) {  // from where a camera is missing: eight stand around it
    const CameraChoice choice = chosen_of(rig, 0, 0, count);
    EXPECT_GT(choice.chosen, static_cast<std::size_t>(count));
    EXPECT_LE(choice.chosen, static_cast<std::size_t>(2 * count));
  }
  EXPECT_EQ(chosen_of(rig, 0, 0, 1).chosen, 1U);
  EXPECT_EQ(chosen_of(rig, 0, 0, 8).chosen, 8U);
}

// Where as many are as near as may be, too: the view crosses cells and comes by the missing camera.
TEST(CameraChoice, SharesAreContinuousAcrossADome) {
  Rig rig = dome();
  std::erase_if(rig.cameras, [](const RigCamera& c) { return c.serial == "cam12"; });
  auto shares = [&](double way) {
    const CameraChoice choice = chosen_of(rig, way, 0.4 * way + 1, 3);
    std::map<std::string, double> share;
    double sum = 0;
    for (std::size_t i = 0; i < choice.chosen; ++i) sum += choice.fade[i];
    for (std::size_t i = 0; i < choice.chosen; ++i)
      share[rig.cameras[static_cast<std::size_t>(choice.listed[i])].serial] = choice.fade[i] / sum;
    return std::pair(share, choice.chosen);
  };
  auto [before, first] = shares(-30);
  std::size_t most = first, least = first;
  for (double way = -30 + 0.05; way < 30; way += 0.05) {
    auto [now, count] = shares(way);
    for (const RigCamera& c : rig.cameras)
      ASSERT_NEAR(now.count(c.serial) ? now[c.serial] : 0, before.count(c.serial) ? before[c.serial] : 0,
                  0.03)
          << c.serial << " at " << way;
    most = std::max(most, count);
    least = std::min(least, count);
    before = now;
  }
  EXPECT_EQ(least, 3U);
  EXPECT_GE(most, 5U) << "the path never meets more cameras than asked for";
}

// On a ring the second neighbours are twice as far and more, wherever the view stands.
TEST(CameraChoice, StaysWithThoseAskedForOnARing) {
  const Rig rig = arc(18, 20);
  for (double degrees = -40; degrees < 40; degrees += 1)
    EXPECT_EQ(chosen(rig, degrees, 3).chosen, 3U) << degrees;
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

// One grey a camera, so that pictures show who counts. The two nearest cameras of a view about 0 degrees see
// nothing of the subject; the third one is camera 2 on one side of it, camera 5 on the other.
Stage seen_by_the_third_camera_only() {
  Stage stage = photographed(arc(8, 20), ball(0.25F, 48), ball(0.25F, 48));
  for (std::size_t c = 0; c < 8; ++c) {
    const Image flat(160, 120, 3, static_cast<std::uint8_t>(30 * c + 20));
    stage.scene.images.frames[c] = make_frame(stage.scene.images.frames[c].info, flat);
  }
  for (const std::size_t c : {3U, 4U}) stage.scene.mattes[c] = make_matte({}, Image(160, 120, 1, 0));
  return stage;
}

TEST_P(Weights, ACameraThatEntersDoesNotOutweighStandInsAtOnce) {
  const Stage stage = seen_by_the_third_camera_only();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  for (const char* method : {"linear", "floating"}) {
    const auto renderer = make(method);
    Image before;
    double moved = 0;
    for (double degrees = -0.5; degrees <= 0.5; degrees += 0.05) {
      const auto picture = renderer->render(scene, view_at(degrees), {});
      ASSERT_THAT(picture, IsOk());
      const Image now = download(*picture);
      for (int y = 50; y < 70 && !before.empty(); ++y)
        for (int x = 60; x < 100; ++x)
          ASSERT_NEAR(now.at(x, y)[0], before.at(x, y)[0], 2) << method << " at " << degrees;
      if (!before.empty()) moved += std::abs(now.at(80, 60)[0] - before.at(80, 60)[0]);
      before = now;
    }
    EXPECT_GT(moved, 0) << method << ": the path does not cross from camera to camera";
  }
}

TEST_P(Weights, ACameraOfLittleWeightDoesNotDecideBesideAnEdgeOfVisibility) {
  Stage stage = seen_by_the_third_camera_only();
  Image half(160, 120, 1, 255);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < 60; ++x) *half.at(x, y) = 0;
  stage.scene.mattes[5] = make_matte({}, half);
  for (const char* method : {"linear", "floating"}) {
    const Image picture = rendered(stage, view_at(2), method);
    for (int y = 50; y < 70; ++y)
      for (int x = 60; x < 100; ++x)
        ASSERT_NEAR(picture.at(x, y)[0], picture.at(x + 1, y)[0], 10) << method << " at " << x << " " << y;
  }
}

TEST(WithoutSpecks, KeepsWhatMostOfNineNeighboursSay) {
  Random random(3);
  for (const int width : {1, 2, 7, 64}) {
    std::array<std::vector<std::uint8_t>, 3> rows;
    for (auto& row : rows)
      for (int x = 0; x < width; ++x)
        row.push_back(static_cast<std::uint8_t>(256 * random.uniform()) |
                      static_cast<std::uint8_t>(256 * random.uniform()));
    std::vector<std::uint8_t> hidden(rows[1].size());
    cpu::without_specks(rows[0].data(), rows[1].data(), rows[2].data(), width, hidden.data());
    for (int x = 0; x < width; ++x)
      for (int bit = 0; bit < 8; ++bit) {
        int count = 0;
        for (const auto& row : rows)
          for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u)
            count += row[static_cast<std::size_t>(u)] >> bit & 1;
        const auto here = static_cast<std::size_t>(x);
        EXPECT_EQ(hidden[here] >> bit & 1, (rows[1][here] >> bit & 1) != 0 && count > 4 ? 1 : 0)
            << width << ": " << x;
      }
  }
}

}  // namespace
}  // namespace floatstage::render
