#include "apps/viewer/play/path_editor.h"

#include <gtest/gtest.h>

namespace floatstage::apps {
namespace {

pipeline::PathKey key_from(double x) {
  pipeline::PathKey key;
  key.eye = {x, 0, 1};
  return key;
}

PathEditor of_three() {
  PathEditor editor;
  for (const double x : {1, 2, 3}) editor.append(key_from(x));
  return editor;
}

TEST(PathEditor, TakesBackEveryChangeInTurnAndMakesItAgain) {
  PathEditor editor = of_three();
  std::vector<pipeline::CameraPath> steps = {editor.path()};
  const auto done = [&] { steps.push_back(editor.path()); };
  editor.move(1, 1.5), done();
  pipeline::PathKey eased = editor.path().keys[2];
  eased.ease_in = 1;
  editor.change(2, eased), done();
  editor.remove(0), done();
  editor.clear(), done();
  for (std::size_t i = steps.size() - 1; i-- > 0;) {
    editor.undo();
    EXPECT_EQ(editor.path(), steps[i]) << i;
  }
  for (std::size_t i = 1; i < steps.size(); ++i) {
    editor.redo();
    EXPECT_EQ(editor.path(), steps[i]) << i;
  }
  EXPECT_FALSE(editor.can_redo());
  editor.undo();
  editor.put(key_from(9), 9);
  EXPECT_FALSE(editor.can_redo()) << "what is done anew ends what could have been";
}

TEST(PathEditor, TakesBackADragInOneStep) {
  PathEditor editor = of_three();
  const pipeline::CameraPath before = editor.path();
  editor.begin_gesture();
  for (double t = 1; t < 1.6; t += 0.1) editor.move(1, t);
  editor.end_gesture();
  editor.undo();
  EXPECT_EQ(editor.path(), before);
  editor.undo();
  EXPECT_EQ(editor.path().keys.size(), 2u);
}

TEST(PathEditor, KeepsKeysInOrderHoweverFarTheyAreMoved) {
  PathEditor editor = of_three();
  editor.move(1, 99);
  EXPECT_LT(editor.path().keys[1].time, editor.path().keys[2].time);
  editor.move(1, -99);
  EXPECT_GT(editor.path().keys[1].time, editor.path().keys[0].time);
  editor.move(0, -1);
  EXPECT_EQ(editor.path().keys[0].time, 0);
  EXPECT_TRUE(pipeline::parse_path(pipeline::to_json(editor.path()), "edited"));
}

TEST(PathEditor, AppendsInRealTimeWhereTheTakeGoesOnAndASecondLaterWhereItStands) {
  PathEditor editor;
  for (const double shown : {1.0, 1.4, 1.4}) {
    pipeline::PathKey key = key_from(shown);
    key.take_time = shown;
    editor.append(key);
  }
  EXPECT_NEAR(editor.path().keys[1].time, 0.4, 1e-12);
  EXPECT_NEAR(editor.path().keys[2].time, 1.4, 1e-12);
}

TEST(PathEditor, LetsAKeyFollowFromWhereItStands) {
  PathEditor editor = of_three();
  const pipeline::SubjectTrack subject{{{0, 0, 1}, {0, 1, 1}, {0, 2, 1}}, 1};
  editor.set_follow(1, true, subject);
  EXPECT_EQ(editor.path().keys[1].eye, Eigen::Vector3d(2, -1, 0)) << "as the subject sees it at one second";
  EXPECT_EQ(sample(editor.path(), 1, subject).eye, Eigen::Vector3d(2, 0, 1));
  editor.set_follow(1, false, subject);
  EXPECT_EQ(editor.path().keys[1].eye, Eigen::Vector3d(2, 0, 1));
}

}  // namespace
}  // namespace floatstage::apps
