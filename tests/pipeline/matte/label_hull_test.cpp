#include "pipeline/matte/label_hull.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"
#include "pipeline/matte/label_correction.h"

// Two balls before eight cameras, and what words about them meet in space.
namespace floatstage::pipeline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::IsEmpty;

class TwoBallsSaid : public testing::Test {
 protected:
  static constexpr double kRadius = 0.25;
  static inline const Vector3d kLeft{-0.7, 0, 1}, kRight{0.7, 0, 1};

  explicit TwoBallsSaid(int cameras = 8)
      : rig_(synthetic_rig({.cameras = cameras, .width = 160, .height = 120, .distance = 4})) {
    for (std::size_t c = 0; c < rig_.cameras.size(); ++c) mattes_.push_back(matte(c, {kLeft, kRight}));
  }
  // What a camera sees of some balls.
  Image matte(std::size_t camera, const std::vector<Vector3d>& balls) const {
    const RigCamera& c = rig_.cameras[camera];
    Image out(c.model.width, c.model.height, 1);
    for (int y = 0; y < out.height; ++y)
      for (int x = 0; x < out.width; ++x) {
        const Vector3d ray =
            c.cam_from_world.rotation.conjugate() * unproject(c.model, {x + 0.5, y + 0.5})->normalized();
        for (const Vector3d& ball : balls) {
          const Vector3d to = ball - c.cam_from_world.center();
          if ((to - to.dot(ray) * ray).norm() < kRadius) *out.at(x, y) = 255;
        }
      }
    return out;
  }
  // A click of a few pixels on a place.
  LabelsAllowed click(std::size_t camera, const Vector3d& at, int label) const {
    const RigCamera& c = rig_.cameras[camera];
    const Vector2d middle = *project(c.model, c.cam_from_world * at);
    LabelsAllowed may(mattes_[camera].pixels.size(), 0);
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        may[mattes_[camera].offset(static_cast<int>(middle.x()) + x, static_cast<int>(middle.y()) + y)] =
            1U << (label - 1);
    return may;
  }
  LabelHull carve(const std::map<int, LabelsAllowed>* said, const Disbelieved& before = {},
                  const LabelPlaces& expected = {}) {
    return label_hull({.rig = rig_,
                       .mattes = mattes_,
                       .frame = 7,
                       .said = said,
                       .before = before,
                       .expected = expected,
                       .labels = 2,
                       .voxels = 200'000,
                       .threads = 2},
                      edge_);
  }
  static std::vector<int> cameras_of(const Disbelieved& disbelieved) {
    std::vector<int> cameras;
    for (const auto& [camera, why] : disbelieved) cameras.push_back(camera);
    return cameras;
  }
  // Voxels of each ball; what lies between them is neither's.
  LabelPlaces places(const LabelHull& hull) const {
    LabelPlaces of(2);
    for (const Eigen::Vector3i& p : hull.volume->places()) {
      const Vector3d at = edge_ * (p.cast<double>() + Vector3d::Constant(0.5));
      if ((at - kLeft).norm() < 1.2 * kRadius) of[0].push_back(p);
      if ((at - kRight).norm() < 1.2 * kRadius) of[1].push_back(p);
    }
    return of;
  }

  const Rig rig_;
  std::vector<Image> mattes_;
  double edge_ = 0;
};

TEST_F(TwoBallsSaid, BelieveEverybodyWhereWordsMeetTheHull) {
  const std::map<int, LabelsAllowed> said{{1, click(1, kRight, 2)}};
  const LabelHull hull = carve(&said);
  ASSERT_TRUE(hull.volume);
  EXPECT_THAT(hull.nowhere, IsEmpty());
  EXPECT_THAT(hull.disbelieved, IsEmpty());
}

TEST_F(TwoBallsSaid, AreCarvedWithoutACameraThatDeniesAWord) {
  mattes_[0] = matte(0, {kLeft});
  const std::map<int, LabelsAllowed> said{{1, click(1, kRight, 2)}};
  const LabelHull hull = carve(&said);
  ASSERT_TRUE(hull.volume);
  EXPECT_THAT(hull.nowhere, IsEmpty());
  EXPECT_THAT(hull.disbelieved, ElementsAre(testing::Pair(0, Lacks{2, 7, 1})));
  EXPECT_FALSE(places(hull)[1].empty());
}

TEST_F(TwoBallsSaid, AreNowhereWhereMostDenyAWord) {
  for (const std::size_t c : {0U, 2U, 3U, 5U, 6U}) mattes_[c] = matte(c, {kLeft});
  const std::map<int, LabelsAllowed> said{{1, click(1, kRight, 2)}};
  const LabelHull hull = carve(&said);
  EXPECT_THAT(hull.disbelieved, IsEmpty());
  ASSERT_EQ(hull.nowhere.size(), 1U);
  EXPECT_EQ(hull.nowhere[0].label, 2);
  EXPECT_EQ(hull.nowhere[0].camera, 1);
  EXPECT_LT(
      (hull.nowhere[0].at - *project(rig_.cameras[1].model, rig_.cameras[1].cam_from_world * kRight)).norm(),
      2);
  EXPECT_FALSE(hull.nowhere[0].denied_by.empty());
}

TEST_F(TwoBallsSaid, AreKeptWhereACameraLosesOneAndBelieveItWhenItShowsHerAgain) {
  const LabelPlaces expected = places(carve(nullptr));
  mattes_[0] = matte(0, {kLeft});
  const LabelHull without = carve(nullptr, {}, expected);
  EXPECT_THAT(without.disbelieved, ElementsAre(testing::Pair(0, Lacks{2, 7, {}})));
  EXPECT_GT(places(without)[1].size(), expected[1].size() / 2);
  const LabelHull still = carve(nullptr, without.disbelieved, expected);
  EXPECT_EQ(still.disbelieved, without.disbelieved);
  mattes_[0] = matte(0, {kLeft, kRight});
  EXPECT_THAT(cameras_of(carve(nullptr, without.disbelieved, expected).disbelieved), IsEmpty());
}

// The voxels' edge was chosen from the one ball that silhouettes had in common.
TEST_F(TwoBallsSaid, HaveVoxelsOfTheSizeOfTheStageOnceBothAreThere) {
  const std::vector<Image> all = mattes_;
  for (const std::size_t c : {0U, 4U}) mattes_[c] = matte(c, {kLeft});
  ASSERT_TRUE(carve(nullptr).volume);
  const double of_one = edge_;
  const std::map<int, LabelsAllowed> said{{1, click(1, kRight, 2)}};
  const LabelHull both = carve(&said);
  ASSERT_TRUE(both.volume);
  EXPECT_EQ(cameras_of(both.disbelieved), (std::vector<int>{0, 4}));
  EXPECT_GT(edge_, 1.5 * of_one);
  const double of_both = edge_;
  const LabelPlaces expected = places(both);
  carve(nullptr, both.disbelieved, expected);
  EXPECT_EQ(edge_, of_both) << "it stays";
}

TEST(LabelPlaces, AreTheSamePlacesWithVoxelsOfAnotherEdge) {
  const LabelPlaces fine{{{0, 0, 0}, {1, 0, 0}, {5, -3, 2}}, {}};
  EXPECT_EQ(with_edge(fine, 0.1, 0.1), fine);
  EXPECT_EQ(with_edge(fine, 0.1, 0.2), (LabelPlaces{{{0, 0, 0}, {2, -2, 1}}, {}}));
}

// So many that two may deny what the hull keeps, and a third ball between the two.
class TwoBallsBeforeMany : public TwoBallsSaid {
 protected:
  static inline const Vector3d kMiddle{0, 0, 1};
  TwoBallsBeforeMany() : TwoBallsSaid(24) {
    for (std::size_t c = 0; c < mattes_.size(); ++c) mattes_[c] = matte(c, {kLeft, kMiddle, kRight});
  }
  // Voxels of the left one, and of the one in the middle.
  LabelPlaces left_and_middle(const LabelHull& hull) const {
    LabelPlaces of = places(hull);
    of[1].clear();
    for (const Eigen::Vector3i& p : hull.volume->places())
      if ((edge_ * (p.cast<double>() + Vector3d::Constant(0.5)) - kMiddle).norm() < 1.2 * kRadius)
        of[1].push_back(p);
    return of;
  }
};

TEST_F(TwoBallsBeforeMany, NameCamerasThatLackOneThoughTheHullHasLostNothing) {
  const LabelPlaces expected = left_and_middle(carve(nullptr));
  for (const std::size_t c : {3U, 11U}) mattes_[c] = matte(c, {kLeft, kRight});
  EXPECT_GT(left_and_middle(carve(nullptr))[1].size(), expected[1].size() / 2)
      << "two of 24 do not take her away";
  LabelHull hull = carve(nullptr, {}, expected);
  for (int frame = 0; frame < 3; ++frame) {
    EXPECT_THAT(hull.disbelieved,
                ElementsAre(testing::Pair(3, Lacks{2, 7, {}}), testing::Pair(11, Lacks{2, 7, {}})));
    hull = carve(nullptr, hull.disbelieved, expected);
  }
  mattes_[3] = matte(3, {kLeft, kMiddle, kRight});
  EXPECT_EQ(cameras_of(carve(nullptr, hull.disbelieved, expected).disbelieved), std::vector<int>{11});
}

TEST_F(TwoBallsBeforeMany, DoNotNameACameraOutOfWhosePictureSheIs) {
  const LabelPlaces expected = left_and_middle(carve(nullptr));
  const Disbelieved before{{3, {2, 7, {}}}};
  LabelPlaces away = expected;
  for (Eigen::Vector3i& p : away[1]) p += Eigen::Vector3i(0, 0, 4000);
  EXPECT_THAT(carve(nullptr, before, away).disbelieved, IsEmpty());
}

TEST_F(TwoBallsSaid, MayBothGo) {
  const LabelPlaces expected = places(carve(nullptr));
  for (std::size_t c = 0; c < mattes_.size(); ++c) mattes_[c] = matte(c, {kLeft});
  const LabelHull hull = carve(nullptr, {}, expected);
  EXPECT_THAT(hull.disbelieved, IsEmpty()) << "nobody shows her any more";
  EXPECT_TRUE(places(hull)[1].empty());
}

TEST_F(TwoBallsSaid, AreGivenToAWordWhereTheyWereNobodys) {
  const LabelHull hull = carve(nullptr);
  std::vector<std::uint8_t> carried;
  for (const Eigen::Vector3i& p : hull.volume->places()) carried.push_back(edge_ * p.x() < 0 ? 1 : 0);
  const LabelCorrection correction =
      find_correction(*hull.volume, {{1, click(1, kRight, 2)}}, mattes_, carried);
  EXPECT_FALSE(correction.none());
  EXPECT_EQ(correction.said, 2U);
  EXPECT_EQ(correction.lost, 0U);
  long right = 0, anew = 0;
  for (std::size_t v = 0; v < carried.size(); ++v) {
    const Vector3d at = edge_ * (hull.volume->places()[v].cast<double>() + Vector3d::Constant(0.5));
    if ((at - kRight).norm() > 0.8 * kRadius) continue;
    ++right, anew += correction.anew[v];
  }
  EXPECT_GT(right, 0);
  EXPECT_EQ(anew, right);
}

}  // namespace
}  // namespace floatstage::pipeline
