#include "calib/scene_matching.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/calib/synthetic_capture.h"

namespace floatstage::calib {
namespace {

constexpr int kPoints = 60;

SceneKeypoints::Descriptor some_descriptor(Random& random) {
  std::array<double, 128> v{};
  double squares = 0;
  for (double& x : v) {
    x = std::max(0.0, random.normal());
    squares += x * x;
  }
  SceneKeypoints::Descriptor out{};
  for (std::size_t i = 0; i < v.size(); ++i)
    out[i] = static_cast<std::int16_t>(std::min(255L, std::lround(512 * v[i] / std::sqrt(squares))));
  return out;
}

// Points of a scene that all cameras see, keypoint i of every picture being point i.
std::vector<SceneKeypoints> sights(const Rig& rig, Random& random) {
  std::vector<SceneKeypoints> pictures(rig.cameras.size());
  for (int p = 0; p < kPoints; ++p) {
    const Eigen::Vector3d place(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                                random.uniform(0.5, 1.5));
    const SceneKeypoints::Descriptor looks = some_descriptor(random);
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      pictures[c].keypoints.push_back(
          {*project(rig.cameras[c].model, rig.cameras[c].cam_from_world * place), 2, 0});
      pictures[c].descriptors.push_back(looks);
    }
  }
  return pictures;
}

TEST(SceneMatching, FindsWhatLooksAlikeInEveryPair) {
  Random random(1);
  const Rig rig = ring_rig(4);
  const std::vector<SceneKeypoints> pictures = sights(rig, random);
  const std::vector<SceneMatches> pairs = match_pictures(pictures, 1);
  ASSERT_EQ(pairs.size(), 6u);
  for (const SceneMatches& pair : pairs) {
    EXPECT_LT(pair.a, pair.b);
    EXPECT_EQ(pair.matches.size(), static_cast<std::size_t>(kPoints));
    for (const SceneMatches::Match& m : pair.matches) EXPECT_EQ(m.i, m.k);
  }
}

TEST(SceneMatching, TakesNothingThatLooksLikeTwoThings) {
  Random random(2);
  const Rig rig = ring_rig(3);
  std::vector<SceneKeypoints> pictures = sights(rig, random);
  for (SceneKeypoints& picture : pictures) picture.descriptors[1] = picture.descriptors[0];
  for (const SceneMatches& pair : match_pictures(pictures, 1))
    EXPECT_EQ(pair.matches.size(), static_cast<std::size_t>(kPoints - 2));
  // Where cameras are says which of the two it is.
  for (const SceneMatches& pair : match_along_lines(pictures, rig, 0.5, 1))
    EXPECT_GE(pair.matches.size(), static_cast<std::size_t>(kPoints - 1));
}

TEST(SceneMatching, AlongLinesIsTheSameAtAnyThreadCountAndNamesNothingOffItsLine) {
  Random random(3);
  const Rig rig = ring_rig(5);
  std::vector<SceneKeypoints> pictures = sights(rig, random);
  pictures[2].keypoints[7].pixel += Eigen::Vector2d(30, 40);  // on one line it may stay, not on all
  const std::vector<SceneMatches> one = match_along_lines(pictures, rig, 2, 1),
                                  many = match_along_lines(pictures, rig, 2, 4);
  ASSERT_EQ(one.size(), many.size());
  int of_seven = 0;
  for (std::size_t p = 0; p < one.size(); ++p) {
    ASSERT_EQ(one[p].matches.size(), many[p].matches.size());
    for (std::size_t m = 0; m < one[p].matches.size(); ++m) {
      EXPECT_EQ(one[p].matches[m].i, many[p].matches[m].i);
      of_seven += one[p].matches[m].i == 7 && (one[p].a == 2 || one[p].b == 2);
    }
  }
  EXPECT_LE(of_seven, 1);
}

TEST(PointsOfMatches, AreWhereTheyWereAndLeaveOutWhatDisagrees) {
  Random random(4);
  const Rig rig = ring_rig(5);
  std::vector<SceneKeypoints> pictures = sights(rig, random);
  std::vector<SceneMatches> pairs = match_pictures(pictures, 1);
  pictures[2].keypoints[7].pixel += Eigen::Vector2d(30, 40);
  const std::vector<SceneFeature> points = points_of_matches(pictures, pairs, rig, 1);
  ASSERT_EQ(points.size(), static_cast<std::size_t>(kPoints));
  int with_four = 0;
  for (const SceneFeature& f : points) {
    with_four += f.seen.size() == 4;
    for (const auto& [camera, pixel] : f.seen) {
      const RigCamera& c = rig.cameras[static_cast<std::size_t>(camera)];
      EXPECT_LT((*project(c.model, c.cam_from_world * f.position) - pixel).norm(), 1e-6);
    }
  }
  EXPECT_EQ(with_four, 1) << "the camera that saw it elsewhere is left out, the others stay";
}

TEST(PointsOfMatches, NeverHaveTwoKeypointsOfOnePicture) {
  Random random(5);
  const Rig rig = ring_rig(3);
  const std::vector<SceneKeypoints> pictures = sights(rig, random);
  std::vector<SceneMatches> pairs = match_pictures(pictures, 1);
  for (SceneMatches& pair : pairs)
    if (pair.a == 0) pair.matches.push_back({3, 4, 1});  // weaker than what is right
  for (const SceneFeature& f : points_of_matches(pictures, pairs, rig, 1)) EXPECT_EQ(f.seen.size(), 3u);
  EXPECT_EQ(points_of_matches(pictures, pairs, rig, 1).size(), static_cast<std::size_t>(kPoints));
}

TEST(PointsOfMatches, AreSeenByThree) {
  Random random(6);
  const Rig rig = ring_rig(2);
  const std::vector<SceneKeypoints> pictures = sights(rig, random);
  EXPECT_TRUE(points_of_matches(pictures, match_pictures(pictures, 1), rig, 1).empty());
}

}  // namespace
}  // namespace floatstage::calib
