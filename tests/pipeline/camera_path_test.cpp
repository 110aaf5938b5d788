#include "pipeline/camera_path.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

PathKey key_at(double time, Vector3d eye) {
  PathKey key;
  key.time = time;
  key.eye = eye;
  return key;
}

Rig ring(int cameras, double arc, double radius) {
  Rig rig;
  for (int i = 0; i < cameras; ++i) {
    const double a = arc * i / cameras;
    RigCamera c;
    c.serial = "c" + std::to_string(i);
    c.model = {
        .width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 320, .cy = 240, .skew = 0, .lens = {}};
    c.cam_from_world = look_at({radius * std::cos(a), radius * std::sin(a), 1.5}, {0, 0, 1}, {0, 0, 1});
    rig.cameras.push_back(c);
  }
  return rig;
}

const Eigen::AlignedBox3d kPerformer(Vector3d(-0.4, -0.4, 0), Vector3d(0.4, 0.4, 2));

TEST(CameraPath, GoesThroughItsKeysAndHoldsBeforeAndAfter) {
  const CameraPath path{{key_at(0, {3, 0, 1}), key_at(1, {0, 3, 1}), key_at(3, {-3, 0, 1})}};
  for (const PathKey& k : path.keys) EXPECT_LT((sample(path, k.time).eye - k.eye).norm(), 1e-12);
  EXPECT_EQ(sample(path, -1).eye, path.keys.front().eye);
  EXPECT_EQ(sample(path, 9).eye, path.keys.back().eye);
}

TEST(CameraPath, MovesSmoothlyAcrossAKey) {
  const CameraPath path{{key_at(0, {3, 0, 1}), key_at(1, {0, 3, 1}), key_at(3, {-3, 0, 1})}};
  const double h = 1e-5;
  const Vector3d before = (sample(path, 1).eye - sample(path, 1 - h).eye) / h;
  const Vector3d after = (sample(path, 1 + h).eye - sample(path, 1).eye) / h;
  EXPECT_LT((before - after).norm(), 1e-3) << "the speed jumps at the key";
}

TEST(CameraPath, SurvivesItsFile) {
  const CameraPath path{{key_at(0, {3.123456789, 0, 1}), key_at(0.1, {0, 3, 1})}};
  const Result<CameraPath> again = parse_path(to_json(path), "path.json");
  ASSERT_THAT(again, IsOk());
  ASSERT_EQ(again->keys.size(), 2u);
  EXPECT_EQ(again->keys[0].eye, path.keys[0].eye);
  EXPECT_EQ(again->keys[1].time, path.keys[1].time);
}

TEST(CameraPath, RefusesFilesThatAreNoPathBySentence) {
  EXPECT_THAT(parse_path("{}", "p.json"), FailsWith(ErrorCode::BadData, "p.json"));
  EXPECT_THAT(parse_path("{\"floatstage_path\": 1, \"keys\": []}", "p.json"),
              FailsWith(ErrorCode::BadData, "no keys"));
  std::string twice = to_json({{key_at(0, {3, 0, 1}), key_at(0, {0, 3, 1})}});
  EXPECT_THAT(parse_path(twice, "p.json"), FailsWith(ErrorCode::BadData, "times must grow"));
  PathKey steep = key_at(0, {0, 0, 5});
  EXPECT_THAT(parse_path(to_json({{steep}}), "p.json"), FailsWith(ErrorCode::BadData, "viewing direction"));
}

TEST(CameraPath, RefusesEveryTruncationOfAFile) {
  const std::string whole = to_json({{key_at(0, {3, 0, 1}), key_at(1, {0, 3, 1})}});
  for (std::size_t n = 0; n + 2 < whole.size(); ++n)
    EXPECT_FALSE(parse_path(whole.substr(0, n), "p.json")) << n;
}

TEST(OrbitPath, TurnsOnceAroundWhenCamerasSurroundTheStage) {
  const CameraPath orbit = orbit_path(ring(8, 2 * std::numbers::pi, 3), kPerformer, 10);
  EXPECT_DOUBLE_EQ(orbit.duration(), 10);
  EXPECT_LT((orbit.keys.front().eye - orbit.keys.back().eye).norm(), 1e-9);
  double turned = 0;
  for (std::size_t i = 1; i < orbit.keys.size(); ++i) {
    const Vector3d a = orbit.keys[i - 1].eye, b = orbit.keys[i].eye;
    turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.head<2>().dot(b.head<2>()));
  }
  EXPECT_NEAR(std::abs(turned), 2 * std::numbers::pi, 1e-6);
  for (const PathKey& k : orbit.keys) EXPECT_NEAR(k.eye.head<2>().norm(), 3, 1e-9);
}

TEST(OrbitPath, StaysInTheArcThatCamerasCover) {
  const Rig rig = ring(10, std::numbers::pi / 2, 3);  // azimuths 0 … 81°
  for (const PathKey& k : orbit_path(rig, kPerformer, 4).keys) {
    const double azimuth = std::atan2(k.eye.y(), k.eye.x()) * 180 / std::numbers::pi;
    EXPECT_GE(azimuth, -1e-6);
    EXPECT_LE(azimuth, 81 + 1e-6);
  }
}

TEST(ViewOf, KeepsTheSubjectBetweenNearAndFar) {
  PathKey key = key_at(0, {3, 0, 1});
  key.target = {0, 0, 1};
  const View view = view_of(key, 640, 480, kPerformer);
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d p = kPerformer.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    const double z = (view.view_from_world * p).z();
    EXPECT_GT(z, view.near_plane);
    EXPECT_LT(z, view.far_plane);
  }
  EXPECT_GT(view.near_plane, 0);
}

}  // namespace
}  // namespace floatstage::pipeline
