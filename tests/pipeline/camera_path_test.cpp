#include "pipeline/camera_path.h"

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
