#include "calib/scene_matching.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>

#include <Eigen/Dense>
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

// All keypoints of one with all of the other, by the essential matrix: what matching along lines must equal.
std::vector<SceneMatches::Match> matched_slowly(const SceneKeypoints& one, const SceneKeypoints& other,
                                                const RigCamera& a, const RigCamera& b, double tolerance) {
  const Rigid3 motion = b.cam_from_world * a.cam_from_world.inverse();
  Eigen::Matrix3d essential;
  for (int c = 0; c < 3; ++c)
    essential.col(c) = motion.translation.cross(motion.rotation.toRotationMatrix().col(c));
  const std::size_t m = one.keypoints.size(), n = other.keypoints.size();
  Eigen::MatrixXd angles = Eigen::MatrixXd::Constant(static_cast<int>(m), static_cast<int>(n), 10);
  for (std::size_t i = 0; i < m; ++i)
    for (std::size_t k = 0; k < n; ++k) {
      const std::optional<Eigen::Vector3d> x = unproject(a.model, one.keypoints[i].pixel),
                                           y = unproject(b.model, other.keypoints[k].pixel);
      if (!x || !y) continue;
      const Eigen::Vector3d of_x = essential * *x, of_y = essential.transpose() * *y;
      const double gap = std::abs(y->dot(of_x));
      if (gap > tolerance / b.model.fx * of_x.head<2>().norm()) continue;
      if (gap > tolerance / a.model.fx * of_y.head<2>().norm()) continue;
      double product = 0;
      for (std::size_t d = 0; d < 128; ++d) product += one.descriptors[i][d] * other.descriptors[k][d];
      angles(static_cast<int>(i), static_cast<int>(k)) = std::acos(std::min(1.0, product / (512 * 512)));
    }
  const auto best = [](Eigen::VectorXd row) {  // the nearest and how much nearer than the next
    Eigen::Index at = 0;
    const double first = row.minCoeff(&at);
    row[at] = std::numbers::pi / 2;  // what nothing alike is apart
    return std::tuple(at, first, first < 0.8 * std::min(row.minCoeff(), std::numbers::pi / 2));
  };
  std::vector<SceneMatches::Match> out;
  for (int i = 0; i < static_cast<int>(m); ++i) {
    const auto [k, near, clear] = best(angles.row(i));
    const auto [back, near_back, clear_back] = best(angles.col(k));
    if (near <= 0.7 && clear && clear_back && back == i) out.push_back({i, static_cast<int>(k), 0});
  }
  return out;
}

RigCamera camera_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const CameraModel& model) {
  RigCamera camera;
  camera.model = model;
  camera.cam_from_world = look_at(eye, target, {0, 0, 1});
  return camera;
}

TEST(SceneMatching, AlongLinesIsWhatComparingAllWithAllGives) {
  const Rig ring = ring_rig(3);
  const CameraModel& lens = ring.cameras[0].model;
  const Eigen::Vector3d middle(0, 0, 1);
  struct Case {
    const char* name;
    RigCamera a, b;
  };
  const Case cases[] = {
      {"towards one another", ring.cameras[0], ring.cameras[1]},
      {"side by side, lines that never meet", camera_at({3, 0, 1}, {0, 0, 1}, lens),
       camera_at({3, 0.4, 1}, {0, 0.4, 1}, lens)},
      {"one behind the other, lines that meet in the picture", camera_at({3, 0, 1}, middle, lens),
       camera_at({3.6, 0.05, 1.02}, middle, lens)},
  };
  for (const Case& c : cases)
    for (const double tolerance : {0.5, 6.0, 60.0}) {
      Random random(8);
      Rig rig;
      rig.cameras = {c.a, c.b};
      rig.cameras[0].serial = "a";
      rig.cameras[1].serial = "b";
      std::vector<SceneKeypoints> pictures = sights(rig, random);
      for (SceneKeypoints& picture : pictures) {
        for (std::size_t p = 0; p < picture.keypoints.size();
             p += 2)  // nearly on their lines, some over them
          picture.keypoints[p].pixel += Eigen::Vector2d(random.normal(), random.normal()) * tolerance / 3;
        for (int p = 0; p < 200; ++p) {  // and what only one of them sees, some of it like something else
          picture.keypoints.push_back(
              {{random.uniform(0, lens.width), random.uniform(0, lens.height)}, 2, 0});
          picture.descriptors.push_back(p % 4 == 0
                                            ? picture.descriptors[static_cast<std::size_t>(p) % kPoints]
                                            : some_descriptor(random));
        }
      }
      const std::vector<SceneMatches> fast = match_along_lines(pictures, rig, tolerance, 1);
      const std::vector<SceneMatches::Match> slow =
          matched_slowly(pictures[0], pictures[1], rig.cameras[0], rig.cameras[1], tolerance);
      ASSERT_EQ(fast.size(), 1u);
      ASSERT_EQ(fast[0].matches.size(), slow.size()) << c.name << ", " << tolerance << " px";
      EXPECT_GE(slow.size(), 20u) << c.name << ", " << tolerance << " px";
      for (std::size_t m = 0; m < slow.size(); ++m) {
        EXPECT_EQ(fast[0].matches[m].i, slow[m].i) << c.name;
        EXPECT_EQ(fast[0].matches[m].k, slow[m].k) << c.name;
      }
    }
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

TEST(SceneMatching, OfManyPicturesComparesEachWithSomeAndStillJoinsWhatAllSee) {
  constexpr std::size_t kCameras = 40;
  Random random(7);
  const Rig rig = ring_rig(kCameras);
  const std::vector<SceneKeypoints> pictures = sights(rig, random);
  for (const std::vector<SceneMatches>& pairs :
       {match_along_lines(pictures, rig, 1, 1), match_pictures(pictures, 1)}) {
    EXPECT_LE(pairs.size(), kCameras * 16);
    const std::vector<SceneFeature> points = points_of_matches(pictures, pairs, rig, 1);
    ASSERT_EQ(points.size(), static_cast<std::size_t>(kPoints));
    for (const SceneFeature& f : points) EXPECT_EQ(f.seen.size(), kCameras);
  }
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
