// Somebody in the colour of the stage around him, on a floor that mirrors, or in the sun and as dark as his
// shadow: cameras tell one another which changes of brightness are he.
#include "pipeline/matte/stage_evidence.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/synthetic/synthetic_studio.h"

namespace floatstage::pipeline {
namespace {

constexpr double kTall = 1.7, kThick = 0.25;  // metres: he is a pillar
constexpr double kStage = 150, kClothes = 118, kMirrored = 128;
constexpr int kWidth = 160, kHeight = 120, kThreads = 2;
enum class What : std::uint8_t { Stage, Pillar, Mirrored, Shadow };

struct Scene {
  double floor = 0;                                            // where he stands
  bool sun = false;                                            // behind the first camera, which he hides
  std::function<double(int x)> light = [](int) { return 1; };  // that falls on all when he is there
  int plates = 6;                                              // cameras whose empty stage was shot
};

bool is_he(const Eigen::Vector3d& at, double floor) {
  return std::hypot(at.x(), at.y()) < kThick && std::abs(at.z() - floor) < kTall;
}

bool shaded(const Eigen::Vector3d& place, const Eigen::Vector3d& to_sun, double floor) {
  for (double s = 0; s < 4; s += 0.01)
    if (is_he(place + s * to_sun, floor)) return true;
  return false;
}

What seen_along(const Eigen::Vector3d& eye, const Eigen::Vector3d& along, const Scene& scene,
                const Eigen::Vector3d& to_sun) {
  for (double s = 1; s < 8; s += 0.01) {
    const Eigen::Vector3d at = eye + s * along;
    if (scene.sun && at.z() <= scene.floor)
      return shaded(at, to_sun, scene.floor) ? What::Shadow : What::Stage;
    if (is_he(at, scene.floor)) return at.z() > scene.floor ? What::Pillar : What::Mirrored;
  }
  return What::Stage;
}

class AsGreyAsTheStage {
 public:
  explicit AsGreyAsTheStage(const Scene& scene = {})
      : rig_(synthetic_rig({.cameras = 6, .width = kWidth, .height = kHeight})),
        stages_(rig_, std::vector<Eigen::Vector2i>(6, {kWidth, kHeight})) {
    Random random(3);
    Eigen::Vector3d to_sun = rig_.cameras[0].cam_from_world.center().normalized();
    to_sun.z() = 0.8;
    const auto noisy = [&](double v) {
      return static_cast<std::uint8_t>(std::clamp(std::lround(v + random.normal()), 0L, 255L));
    };
    for (std::size_t i = 0; i < rig_.cameras.size(); ++i) {
      const RigCamera& camera = rig_.cameras[i];
      Image stage(kWidth, kHeight, 3), picture(kWidth, kHeight, 3);
      std::vector<What> what;
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const Eigen::Vector3d along = camera.cam_from_world.rotation.conjugate() *
                                        unproject(camera.model, {x + 0.5, y + 0.5})->normalized();
          what.push_back(seen_along(camera.cam_from_world.center(), along, scene, to_sun));
          const double now = what.back() == What::Stage      ? kStage
                             : what.back() == What::Mirrored ? kMirrored
                                                             : kClothes;
          for (int c = 0; c < 3; ++c) {
            stage.at(x, y)[c] = noisy(kStage);
            picture.at(x, y)[c] = noisy(now * scene.light(x));
          }
        }
      if (static_cast<int>(i) < scene.plates)
        stages_.learn(i, *matting::StillBackdrop::of_empty_stage({stage}));
      pictures_.push_back(std::move(picture));
      what_.push_back(std::move(what));
    }
    stages_.look(pictures_, pictures_, kThreads);
  }

  // After a turn that found him as he is.
  bool hear() {
    const recon::SharedView shared = *recon::shared_view(rig_);
    recon::OccupancyGrid grid(rig_, shared.box, 60'000, std::vector<Eigen::Vector2i>(6, {kWidth, kHeight}),
                              shared.seen_by, kThreads);
    std::vector<recon::OddsPicture> turn;
    for (const std::vector<What>& what : what_) {
      turn.push_back({kWidth, kHeight, {}});
      for (const What w : what) turn.back().odds.push_back(w == What::Pillar ? 3.0f : -3.0f);
    }
    grid.fuse(turn, {});
    return stages_.hear_others(grid, shared, 0, kThreads);
  }

  // The share of the pixels that show this which speak for him, in the first camera.
  double speaking(What what) const {
    double all = 0, speaking = 0;
    for (std::size_t p = 0; p < what_[0].size(); ++p)
      if (what_[0][p] == what) ++all, speaking += stages_.of(0).odds[p] > 0;
    return speaking / all;
  }

  // Likewise of those that show the stage for certain.
  double denied(What what) const {
    double all = 0, denied = 0;
    for (std::size_t p = 0; p < what_[0].size(); ++p)
      if (what_[0][p] == what) ++all, denied += stages_.of(0).tells_of(p) && stages_.of(0).odds[p] < -1;
    return denied / all;
  }

 private:
  Rig rig_;
  StageEvidence stages_;
  std::vector<Image> pictures_;
  std::vector<std::vector<What>> what_;
};

TEST(StageEvidence, WhoIsAsGreyAsTheStageIsFoundWhereOthersSeeAChangeToo) {
  AsGreyAsTheStage scene;
  EXPECT_EQ(scene.speaking(What::Pillar), 0);  // by itself each camera takes him for a shadow
  ASSERT_TRUE(scene.hear());
  EXPECT_GT(scene.speaking(What::Pillar), 0.75);  // all but what is near the floor
  EXPECT_EQ(scene.speaking(What::Stage), 0);
}

TEST(StageEvidence, WhatAFloorMirrorsIsNobody) {
  AsGreyAsTheStage scene;
  ASSERT_TRUE(scene.hear());
  EXPECT_LT(scene.speaking(What::Mirrored), 0.1);
}

TEST(StageEvidence, WhoHidesHisShadowAndIsAsDarkAsItIsNotTakenForIt) {
  AsGreyAsTheStage scene({.sun = true});
  EXPECT_GT(scene.denied(What::Pillar), 0.25);
  ASSERT_TRUE(scene.hear());
  EXPECT_LT(scene.denied(What::Pillar), 0.07);
  EXPECT_GT(scene.speaking(What::Pillar), 0.5);
  EXPECT_GT(scene.denied(What::Shadow), 0.99);
}

TEST(StageEvidence, LightThatChangesAllOverTellsNothing) {
  for (const auto& light : std::vector<std::function<double(int)>>{
           [](int) { return 0.92; }, [](int) { return 1.08; }, [](int x) { return 0.85 + 0.0015 * x; }}) {
    AsGreyAsTheStage scene({.light = light});
    const double before = scene.speaking(What::Stage);
    EXPECT_FALSE(scene.hear()) << light(0);
    EXPECT_EQ(scene.speaking(What::Stage), before) << light(0);
  }
}

TEST(StageEvidence, NobodyIsHeardWhereNoFloorIsKnown) {
  AsGreyAsTheStage above({.floor = 1}), below({.floor = -1});
  EXPECT_FALSE(above.hear());
  EXPECT_FALSE(below.hear());
  EXPECT_EQ(above.speaking(What::Pillar), 0);
}

TEST(StageEvidence, TwoStagesAreTooFewToHear) {
  AsGreyAsTheStage two({.plates = 2}), three({.plates = 3});
  EXPECT_FALSE(two.hear());
  EXPECT_TRUE(three.hear());
}

}  // namespace
}  // namespace floatstage::pipeline
