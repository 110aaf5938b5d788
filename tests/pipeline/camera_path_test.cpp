#include "pipeline/camera_path.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/subject.h"
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

TEST(CameraPath, StandsStillAtAKeyThatItIsEasedInto) {
  CameraPath path{{key_at(0, {3, 0, 1}), key_at(1, {0, 3, 1}), key_at(3, {-3, 0, 1})}};
  path.keys[1].ease_in = path.keys[1].ease_out = 1;
  const double h = 1e-4;
  EXPECT_LT((sample(path, 1).eye - sample(path, 1 - h).eye).norm() / h, 1e-2);
  EXPECT_LT((sample(path, 1 + h).eye - sample(path, 1).eye).norm() / h, 1e-2);
  EXPECT_EQ(sample(path, 1).eye, path.keys[1].eye);
}

TEST(CameraPath, GoesAroundTheTargetAsOftenAsItsKeySays) {
  CameraPath path{{key_at(0, {3, 0, 1}), key_at(2, {3, 0, 1})}};
  path.keys[0].orbit = 1;
  for (double t = 0; t <= 2; t += 0.125) {
    const Vector3d eye = sample(path, t).eye;
    EXPECT_NEAR(eye.head<2>().norm(), 3, 1e-12) << t;
    EXPECT_NEAR(eye.z(), 1, 1e-12) << t;
  }
  EXPECT_LT((sample(path, 0.5).eye - Vector3d(0, 3, 1)).norm(), 1e-9) << "counter-clockwise, seen from above";
  path.keys[0].orbit = -1;
  EXPECT_LT((sample(path, 0.5).eye - Vector3d(0, -3, 1)).norm(), 1e-9);
  path.keys[0].orbit = 0;
  path.keys[1].eye = {0, -1, 3};
  const Vector3d half = sample(path, 1).eye;
  EXPECT_NEAR(half.head<2>().norm(), 2, 1e-9) << "nearer as it goes";
  EXPECT_NEAR(half.z(), 2, 1e-9);
  EXPECT_NEAR(half.x(), -half.y(), 1e-9) << "the shortest way";
}

TEST(CameraPath, KeepsItsSpeedFromAStraightWayIntoAnOrbitAndOut) {
  CameraPath path{{key_at(0, {5, -3, 1}), key_at(1, {3, 0, 1}), key_at(2, {0, 3, 1}), key_at(3, {-3, 0, 1}),
                   key_at(4, {-5, -3, 1})}};
  path.keys[1].orbit = path.keys[2].orbit = 0;
  const double h = 1e-6;
  for (const double key : {1, 2, 3}) {
    const Vector3d before = (sample(path, key).eye - sample(path, key - h).eye) / h;
    const Vector3d after = (sample(path, key + h).eye - sample(path, key).eye) / h;
    EXPECT_LT((before - after).norm(), 1e-2) << "at " << key;
    EXPECT_GT(before.norm(), 1) << "at " << key;
  }
}

TEST(CameraPath, GoesAlongWithTheSubjectWhereItsKeysFollow) {
  SubjectTrack subject{{{0, 0, 1}, {1, 0, 1}, {2, 0, 1}}, 1};
  CameraPath path{{key_at(0, {3, 0, 0}), key_at(2.5, {3, 0, 0})}};
  path.keys[0].follow = path.keys[1].follow = true;
  EXPECT_EQ(sample(path, 0, subject).eye, Vector3d(3, 0, 1));
  EXPECT_EQ(sample(path, 1.5, subject).eye, Vector3d(4, 0, 1)) << "as the frame that is shown";
  EXPECT_EQ(sample(path, 9, subject).target, Vector3d(2, 0, 1));
  EXPECT_FALSE(sample(path, 0, subject).follow) << "it is in the world";
  path.keys[1].follow = false;
  EXPECT_EQ(sample(path, 2.5, subject).eye, Vector3d(3, 0, 0));
}

TEST(CameraPath, FreezesAndSlowsTheTakeBetweenKeysThatSayWhatIsShown) {
  CameraPath path{{key_at(1, {3, 0, 1}), key_at(2, {0, 3, 1}), key_at(4, {-3, 0, 1}), key_at(6, {0, 3, 1})}};
  EXPECT_EQ(take_time(path, 1.5), 1.5) << "no key says anything";
  path.keys[0].take_time = 0.5;
  path.keys[2].take_time = 0.5;  // frozen for three seconds
  path.keys[3].take_time = 1;    // a quarter of the speed
  EXPECT_EQ(take_time(path, 0.75), 0.25) << "before it in real time";
  EXPECT_EQ(take_time(path, 1), 0.5);
  EXPECT_EQ(take_time(path, 3), 0.5);
  EXPECT_EQ(take_time(path, 5), 0.75);
  EXPECT_EQ(take_time(path, 7), 2) << "after it in real time";
}

TEST(CameraPath, ShowsTheFrameNearestToItsTimeOrAllInTurn) {
  CameraPath path{{key_at(0, {3, 0, 1}), key_at(2, {0, 3, 1})}};
  const std::vector<int> all = {0, 1, 2, 3}, some = {0, 2, 3};
  EXPECT_EQ(shown_at(path, 0.5, 10, all), 1u) << "played, and begun again";
  EXPECT_EQ(shown_at(path, 0.5, 10, some), 2u);
  path.keys[0].take_time = 0.1;
  path.keys[1].take_time = 0.1;
  EXPECT_EQ(shown_at(path, 0.5, 10, all), 1u) << "frozen";
  path.keys[1].take_time = 0.25;
  EXPECT_EQ(shown_at(path, 2, 10, some), 1u);
  EXPECT_EQ(shown_at(path, 99, 10, all), 3u) << "held at the take's end";
  EXPECT_EQ(shown_at(path, 1, 0, all), 0u) << "one instant";
}

TEST(CameraPath, KeepsWhatItsKeysSayInItsFileAndReadsOlderFiles) {
  CameraPath path{{key_at(0, {3, 0, 1}), key_at(1, {0, 3, 1})}};
  path.keys[0].take_time = 1.25, path.keys[0].ease_out = 0.5, path.keys[0].orbit = -2;
  path.keys[1].ease_in = 1, path.keys[1].follow = true;
  const Result<CameraPath> again = parse_path(to_json(path), "path.json");
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(*again, path);
  const std::string first = R"({"floatstage_path": 1, "keys": [
    {"time": 0, "eye": [3, 0, 1], "target": [0, 0, 0], "up": [0, 0, 1], "fov_y": 40}]})";
  const Result<CameraPath> older = parse_path(first, "old.json");
  ASSERT_THAT(older, IsOk());
  EXPECT_EQ(older->keys, std::vector{key_at(0, {3, 0, 1})});
  std::string newer = first;
  newer.replace(newer.find("1"), 1, "3");
  EXPECT_THAT(parse_path(newer, "new.json"), FailsWith(ErrorCode::Unsupported, "formats 1 to 2"));
}

TEST(CameraPath, RefusesWhatAKeyCannotSayBySentence) {
  for (const char* bad : {"\"ease_in\": 1.5", "\"ease_out\": -1", "\"follow\": 1", "\"orbit\": \"twice\"",
                          "\"take_time\": null", "\"take_time\": 1e300"}) {
    std::string json = to_json({{key_at(0, {3, 0, 1})}});
    json.insert(json.find("\"eye\""), std::string(bad) + ", ");
    const std::string name = std::string(bad).substr(1, std::string(bad).find(':') - 2);
    EXPECT_THAT(parse_path(json, "p.json"), FailsWith(ErrorCode::BadData, name)) << bad;
  }
}

TEST(SubjectTrack, IsSmoothBetweenAndTrueAtItsEnds) {
  std::vector<std::optional<Vector3d>> middles;
  for (int frame = 0; frame < 50; ++frame)
    middles.emplace_back(Vector3d(0.04 * frame, frame % 2 ? 0.1 : -0.1, 1));  // a walk that sways
  middles[20].reset();
  const SubjectTrack track = smoothed_track(middles, 25);
  ASSERT_EQ(track.centres.size(), 50u);
  EXPECT_EQ(track.centres.front(), *middles.front());
  EXPECT_EQ(track.centres.back(), *middles.back());
  for (std::size_t frame = 15; frame < 35; ++frame) {
    EXPECT_NEAR(track.centres[frame].x(), 0.04 * static_cast<double>(frame), 2e-3)
        << "it does not lag behind";
    EXPECT_LT(std::abs(track.centres[frame].y()), 0.02) << frame;
  }
  EXPECT_EQ(track.at(0.99), track.centres[24]) << "of the frame that is shown";
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
