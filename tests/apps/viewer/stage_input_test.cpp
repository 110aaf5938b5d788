#include "apps/viewer/play/stage_input.h"

#include <gtest/gtest.h>

#include "tests/apps/viewer/hands.h"

namespace floatstage::apps {
namespace {

using Kind = InputEvent::Kind;

PlayerState state() {
  pipeline::PathKey home;
  home.eye = {0, -4, 1}, home.target = {0, 0, 1}, home.up = {0, 0, 1}, home.fov_y = 40;
  PlayerState s{TimeLine(20, 25), ViewerCamera(home)};
  s.methods = {"nearest", "linear", "floating"};
  return s;
}

StageInput stage() {
  StageInput hands;
  hands.set_area(270, 0, 1000, 700);
  return hands;
}

TEST(StageInput, TurnsByADragBetweenTwoPicturesAsByASlowOne) {
  PlayerState quick = state(), slow = state();
  StageInput hands = stage();
  const std::vector<InputEvent> drag = {at(Kind::Press, 500, 300), at(Kind::Move, 560, 300),
                                        at(Kind::Move, 640, 340), at(Kind::Release, 640, 340)};
  hands.take(drag, true, quick);
  for (const InputEvent& e : drag) hands.take({&e, 1}, true, slow);
  EXPECT_NE(quick.camera.key().eye, state().camera.key().eye);
  EXPECT_EQ(quick.camera.key().eye, slow.camera.key().eye);
}

TEST(StageInput, LeavesDragsAloneThatBeganInAPanel) {
  PlayerState s = state();
  StageInput hands = stage();
  hands.take({{at(Kind::Press, 100, 300), at(Kind::Move, 600, 300), at(Kind::Release, 600, 300)}}, true, s);
  EXPECT_EQ(s.camera.key().eye, state().camera.key().eye);
}

TEST(StageInput, FollowsADragThatLeavesTheStageUntilItsButtonIsReleased) {
  PlayerState s = state();
  StageInput hands = stage();
  hands.take({{at(Kind::Press, 300, 300), at(Kind::Move, 100, 300), at(Kind::Release, 100, 300, 1)}}, true,
             s);
  const Eigen::Vector3d eye = s.camera.key().eye;
  hands.take({{at(Kind::Move, 50, 300), at(Kind::Release, 50, 300)}}, true, s);
  EXPECT_NE(s.camera.key().eye, eye) << "another button was released";
  const Eigen::Vector3d last = s.camera.key().eye;
  hands.take({{at(Kind::Move, 400, 300)}}, true, s);
  EXPECT_EQ(s.camera.key().eye, last);
}

TEST(StageInput, LooksPansAndZooms) {
  for (const int button : {1, 2}) {
    PlayerState s = state();
    stage().take({{at(Kind::Press, 500, 300, button), at(Kind::Release, 600, 300, button)}}, true, s);
    EXPECT_NE(s.camera.key().target, state().camera.key().target) << button;
    EXPECT_EQ(s.camera.key().eye == state().camera.key().eye, button == 1) << "a look turns, a pan moves";
  }
  PlayerState s = state();
  InputEvent wheel = at(Kind::Wheel, 500, 300);
  wheel.wheel = 2;
  stage().take({&wheel, 1}, true, s);
  EXPECT_LT((s.camera.key().eye - s.camera.key().target).norm(), 4);
}

TEST(StageInput, LetsGoWhenTheCameraRidesItsPath) {
  PlayerState s = state();
  StageInput hands = stage();
  hands.take({{at(Kind::Press, 500, 300)}}, true, s);
  hands.take({{at(Kind::Move, 700, 300)}}, false, s);
  hands.take({{at(Kind::Move, 800, 300)}}, true, s);
  EXPECT_EQ(s.camera.key().eye, state().camera.key().eye);
}

TEST(Shortcuts, CountEveryKeyOfASlowPicture) {
  PlayerState s = state();
  const pipeline::PathKey home = s.camera.key();
  take_shortcuts({{key(kKeyRight), key(kKeyRight), key(kKeyRight), key('K'), key('K'), key('C'), key('2')}},
                 home, s);
  EXPECT_EQ(s.time.frame(), 3);
  EXPECT_EQ(s.path.path().keys.size(), 2u);
  EXPECT_TRUE(s.show_cameras);
  EXPECT_EQ(s.left, 1);
  take_shortcuts({{key('X'), key('X', true), key(kKeyLeft, true)}}, home, s);
  EXPECT_TRUE(s.split) << "a key that is held is no second press";
  EXPECT_EQ(s.time.frame(), 2) << "but steps on";
}

TEST(Shortcuts, SplitBetweenLinearAndFloatingAndComeBack) {
  PlayerState s = state();
  s.methods = {"nearest", "linear", "floating"};
  s.left = s.right = 2;
  const pipeline::PathKey home = s.camera.key();
  take_shortcuts({{key('X')}}, home, s);
  EXPECT_TRUE(s.split);
  EXPECT_EQ(s.methods[static_cast<std::size_t>(s.left)], "linear");
  EXPECT_EQ(s.methods[static_cast<std::size_t>(s.right)], "floating");
  take_shortcuts({{key('X'), key(kKeyF3)}}, home, s);
  EXPECT_FALSE(s.split);
  EXPECT_EQ(s.left, 2) << "the method from before";
  EXPECT_TRUE(s.show_times);
  s.right = 0;
  take_shortcuts({{key('X')}}, home, s);
  EXPECT_EQ(s.left, 2) << "who chose two methods keeps them";
}

TEST(Shortcuts, BringTheCameraHome) {
  PlayerState s = state();
  const pipeline::PathKey home = s.camera.key();
  s.camera.orbit(1, 0.2);
  take_shortcuts({{key('H')}}, home, s);
  EXPECT_EQ(s.camera.key().eye, home.eye);
}

}  // namespace
}  // namespace floatstage::apps
