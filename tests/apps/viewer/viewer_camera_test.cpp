#include "apps/viewer/play/viewer_camera.h"

#include <cmath>

#include <gtest/gtest.h>

#include "apps/viewer/play/path_editor.h"
#include "apps/viewer/window/time_line.h"

namespace floatstage::apps {
namespace {

using Eigen::Vector3d;

pipeline::PathKey start() {
  pipeline::PathKey key;
  key.eye = {3, 0, 1};
  key.target = {0, 0, 1};
  return key;
}

TEST(ViewerCamera, OrbitKeepsItsDistanceAndItsTarget) {
  ViewerCamera camera(start());
  camera.orbit(0.7, 0.3);
  EXPECT_NEAR((camera.key().eye - camera.key().target).norm(), 3, 1e-12);
  EXPECT_EQ(camera.key().target, start().target);
  EXPECT_NEAR(camera.key().eye.z() - 1, 3 * std::sin(0.3), 1e-12);
}

TEST(ViewerCamera, NeverGoesOverThePoles) {
  ViewerCamera camera(start());
  for (int i = 0; i < 100; ++i) camera.orbit(0.1, 0.5);
  const Vector3d d = camera.key().eye - camera.key().target;
  EXPECT_GT(d.cross(camera.key().up).norm(), 0.01) << "looking straight down has no right";
  EXPECT_GT(d.z(), 0);
}

TEST(ViewerCamera, LooksAboutFromWhereItStands) {
  ViewerCamera camera(start());
  camera.look(0.5, 0);
  EXPECT_EQ(camera.key().eye, start().eye);
  const Vector3d was = start().target - start().eye, is = camera.key().target - camera.key().eye;
  EXPECT_NEAR(std::acos(was.normalized().dot(is.normalized())), 0.5, 1e-9);
  const Vector3d right = was.cross(Vector3d::UnitZ());
  EXPECT_GT(is.dot(right), 0) << "look right turns right";
}

TEST(ViewerCamera, PansByThePicturesHeight) {
  ViewerCamera camera(start());
  camera.pan(0, 1);
  EXPECT_NEAR(camera.key().eye.z() - 1, 2 * 3 * std::tan(20 * M_PI / 180), 1e-12);
}

TEST(ViewerCamera, ZoomNeverReachesTheTarget) {
  ViewerCamera camera(start());
  camera.zoom(2);
  EXPECT_NEAR((camera.key().eye - camera.key().target).norm(), 1.5, 1e-12);
  for (int i = 0; i < 100; ++i) camera.zoom(2);
  EXPECT_GT((camera.key().eye - camera.key().target).norm(), 0.01);
}

TEST(ViewerCamera, FliesAlongItsOwnAxes) {
  ViewerCamera camera(start());
  camera.fly(0, 0, 1);
  EXPECT_LT((camera.key().eye - Vector3d(2, 0, 1)).norm(), 1e-12);
  camera.fly(1, 0, 0);
  EXPECT_LT((camera.key().eye - Vector3d(2, 1, 1)).norm(), 1e-12) << "looking along -x, right is +y";
}

TEST(TimeLine, PlaysAtTheRecordedRateTimesItsSpeed) {
  TimeLine time(100, 25);
  time.advance(1);
  EXPECT_EQ(time.frame(), 0) << "it stands until it plays";
  time.playing = true;
  time.advance(1);
  EXPECT_EQ(time.frame(), 25);
  time.speed = 0.5;
  time.advance(1);
  EXPECT_EQ(time.frame(), 37);
}

TEST(TimeLine, BeginsAgainWhenItLoopsAndStandsWhenItDoesNot) {
  TimeLine time(10, 10);
  time.playing = true;
  time.advance(1.25);
  EXPECT_EQ(time.frame(), 2);
  time.loop = false;
  time.advance(5);
  EXPECT_EQ(time.frame(), 9);
  EXPECT_FALSE(time.playing);
}

TEST(TimeLine, StepsAndSeeksWithinTheTake) {
  TimeLine time(10, 10);
  time.playing = true;
  time.step(-1);
  EXPECT_EQ(time.frame(), 0);
  EXPECT_FALSE(time.playing) << "stepping stops";
  time.seek(99);
  EXPECT_EQ(time.frame(), 9);
}

TEST(TimeLine, OfOneInstantNeverMoves) {
  TimeLine time(1, 0);
  time.playing = true;
  time.advance(10);
  EXPECT_EQ(time.frame(), 0);
}

TEST(PathEditor, KeepsKeysInOrderOfTime) {
  PathEditor editor;
  editor.append(start());
  editor.append(start());
  editor.put(start(), 0.5);
  ASSERT_EQ(editor.path().keys.size(), 3u);
  EXPECT_EQ(editor.path().keys[1].time, 0.5);
  EXPECT_EQ(editor.path().keys[2].time, 1);
}

TEST(PathEditor, ReplacesAKeyThatIsThereAlready) {
  PathEditor editor;
  editor.append(start());
  pipeline::PathKey other = start();
  other.eye = {0, 4, 2};
  editor.put(other, 0);
  ASSERT_EQ(editor.path().keys.size(), 1u);
  EXPECT_EQ(editor.path().keys[0].eye, other.eye);
  editor.remove(0);
  EXPECT_TRUE(editor.empty());
}

}  // namespace
}  // namespace floatstage::apps
