#include <gtest/gtest.h>

#include "apps/viewer/mattes/editor_state.h"

namespace floatstage::apps {
namespace {

// A photograph of 160x120 in a part of the window that is twice as large and begins at (300, 10).
EditorState state() {
  EditorState s{TimeLine(20, 25), EditSession({}, 20, 160, 120), PictureFit(160, 120)};
  s.fit.set_area(300, 10, 320, 240);
  s.flicker.resize(20);
  return s;
}

InputEvent at(InputEvent::Kind kind, double x, double y, int button = 0) {
  InputEvent e;
  e.kind = kind, e.x = x, e.y = y, e.button = button;
  return e;
}

EditorRequests press_key(EditorState& s, int key, bool control = false, bool shift = false) {
  InputEvent e;
  e.kind = InputEvent::Kind::Key, e.key = key, e.control = control, e.shift = shift;
  return take_input(e, s);
}

EditorRequests drag(EditorState& s, double x0, double y0, double x1, double y1, int button = 0) {
  take_input(at(InputEvent::Kind::Press, x0, y0, button), s);
  take_input(at(InputEvent::Kind::Move, x1, y1), s);
  return take_input(at(InputEvent::Kind::Release, x1, y1, button), s);
}

TEST(PictureFit, TakesTheWindowToThePhotographAndBack) {
  PictureFit fit(160, 120);
  fit.set_area(300, 10, 400, 240);  // wider than the photograph: bars at the sides
  EXPECT_EQ(fit.scale(), 2);
  EXPECT_EQ(fit.to_photograph(340, 10), Eigen::Vector2d(0, 0));
  EXPECT_EQ(fit.to_window({160, 120}), Eigen::Vector2d(660, 250));
  const Eigen::Vector2d fixed = fit.to_photograph(420, 100);
  fit.zoom(420, 100, 4);
  EXPECT_EQ(fit.scale(), 8);
  EXPECT_LT((fit.to_photograph(420, 100) - fixed).norm(), 1e-9) << "what the pointer is on stays there";
  fit.pan(80, 0);
  EXPECT_LT((fit.to_photograph(500, 100) - fixed).norm(), 1e-9);
  fit.zoom(420, 100, 1e-3);
  EXPECT_EQ(fit.scale(), 2) << "no smaller than whole";
  EXPECT_EQ(fit.to_photograph(340, 10), Eigen::Vector2d(0, 0));
  EXPECT_FALSE(fit.holds(299, 20));
  EXPECT_TRUE(fit.holds(300, 10));
}

TEST(EditorInput, ChoosesWhoseStrokesAreOneLabelAfterTheOther) {
  EditorState s = state();
  press_key(s, 'L');
  EXPECT_EQ(s.session.subject, "");
  EXPECT_EQ(s.status, "the take has no labels; write the name of one in the panel");
  s.labels = {"woman", "man"};
  press_key(s, 'L');
  EXPECT_EQ(s.session.subject, "woman");
  EXPECT_EQ(s.status, "strokes are 'woman'");
  drag(s, 320, 30, 320, 30);
  EXPECT_EQ(s.session.keyframe(0)->strokes.at(0).subject, "woman");
  press_key(s, 'L');
  EXPECT_EQ(s.session.subject, "man");
  press_key(s, 'L');
  EXPECT_EQ(s.session.subject, "");
  EXPECT_EQ(s.status, "strokes are nobody's in particular");
}

TEST(EditorInput, TakesLabelsThatArePossibleNames) {
  EditorState s = state();
  EXPECT_FALSE(choose_label(s, "../x"));
  EXPECT_EQ(s.status, "'../x' cannot be a label: letters, digits, '-' and '_', at most 64");
  EXPECT_FALSE(choose_label(s, ""));
  EXPECT_TRUE(s.labels.empty() && s.session.subject.empty());
  EXPECT_TRUE(choose_label(s, "woman"));
  EXPECT_TRUE(choose_label(s, "man"));
  EXPECT_TRUE(choose_label(s, "woman"));
  EXPECT_EQ(s.labels, (std::vector<std::string>{"woman", "man"}));
  EXPECT_EQ(s.session.subject, "woman");
}

TEST(EditorInput, ClicksSubjectWithTheLeftAndBackgroundWithTheRightButton) {
  EditorState s = state();
  s.time.seek(3);
  EXPECT_TRUE(drag(s, 320, 30, 320, 30).edited);
  EXPECT_TRUE(drag(s, 340, 50, 360, 50, 1).edited);
  const MatteKeyframe* k = s.session.keyframe(3);
  ASSERT_NE(k, nullptr);
  ASSERT_EQ(k->strokes.size(), 2u);
  EXPECT_EQ(k->strokes[0].label, MatteLabel::Foreground);
  EXPECT_EQ(k->strokes[0].points, (std::vector<Eigen::Vector2d>{{10, 10}}));
  EXPECT_EQ(k->strokes[1].label, MatteLabel::Background);
  EXPECT_EQ(k->strokes[1].points, (std::vector<Eigen::Vector2d>{{20, 20}, {30, 20}}));
}

TEST(EditorInput, LeavesPressesOnPanelsToThem) {
  EditorState s = state();
  EXPECT_FALSE(drag(s, 100, 30, 400, 100).edited);
  EXPECT_EQ(s.session.edits(), CameraEdits());
  EXPECT_EQ(s.session.drawing(), nullptr);
}

TEST(EditorInput, FinishesAStrokeOnlyWithTheButtonThatBeganIt) {
  EditorState s = state();
  take_input(at(InputEvent::Kind::Press, 400, 100, 0), s);
  EXPECT_FALSE(take_input(at(InputEvent::Kind::Press, 400, 100, 1), s).edited);
  EXPECT_FALSE(take_input(at(InputEvent::Kind::Release, 400, 100, 1), s).edited);
  EXPECT_NE(s.session.drawing(), nullptr);
  EXPECT_TRUE(take_input(at(InputEvent::Kind::Release, 400, 100, 0), s).edited);
}

TEST(EditorInput, PansWithTheMiddleButtonAndZoomsWithTheWheel) {
  EditorState s = state();
  InputEvent wheel = at(InputEvent::Kind::Wheel, 400, 100);
  wheel.wheel = 5;
  take_input(wheel, s);
  EXPECT_GT(s.fit.scale(), 4);
  take_input(at(InputEvent::Kind::Press, 400, 100, 2), s);
  const Eigen::Vector2d below = s.fit.to_photograph(400, 100);
  take_input(at(InputEvent::Kind::Move, 420, 110), s);
  EXPECT_LT((s.fit.to_photograph(420, 110) - below).norm(), 1e-9);
  EXPECT_FALSE(take_input(at(InputEvent::Kind::Release, 420, 110, 2), s).edited);
  press_key(s, '0');
  EXPECT_EQ(s.fit.scale(), 2);
}

TEST(EditorInput, UndoesAndRedoes) {
  EditorState s = state();
  drag(s, 400, 100, 400, 100);
  EXPECT_TRUE(press_key(s, 'Z', true).edited);
  EXPECT_EQ(s.session.edits(), CameraEdits());
  EXPECT_FALSE(press_key(s, 'Z', true).edited);
  EXPECT_NE(s.status.find("nothing to undo"), std::string::npos);
  EXPECT_TRUE(press_key(s, 'Z', true, true).edited);
  EXPECT_EQ(s.session.edits().keyframes.size(), 1u);
  EXPECT_FALSE(press_key(s, 'Y', true).edited);
  EXPECT_FALSE(press_key(s, 'Z').edited) << "without Ctrl it means nothing";
}

TEST(EditorInput, JumpsToKeyframesAndWorstFrames) {
  EditorState s = state();
  for (int frame : {4, 11}) {
    s.time.seek(frame);
    drag(s, 400, 100, 400, 100);
  }
  s.time.seek(7);
  press_key(s, '.');
  EXPECT_EQ(s.time.frame(), 11);
  press_key(s, '.');
  EXPECT_EQ(s.time.frame(), 11);
  EXPECT_NE(s.status.find("no keyframe after"), std::string::npos);
  press_key(s, ',');
  EXPECT_EQ(s.time.frame(), 4);
  press_key(s, 'W');
  EXPECT_EQ(s.time.frame(), 4) << "nothing has been metered";
  s.flicker[9] = 0.3, s.flicker[15] = 0.1;
  s.worst = worst_frames(s.flicker);
  press_key(s, 'W');
  EXPECT_EQ(s.time.frame(), 9);
  EXPECT_NE(s.status.find("30 %"), std::string::npos) << s.status;
  press_key(s, 'W');
  EXPECT_EQ(s.time.frame(), 15);
}

TEST(EditorInput, ChoosesViewsToolsAndBrushes) {
  EditorState s = state();
  press_key(s, '4');
  EXPECT_EQ(s.view, MatteView::Matte);
  press_key(s, 'V');
  EXPECT_EQ(s.view, MatteView::Difference);
  press_key(s, '9');
  EXPECT_EQ(s.view, MatteView::Difference) << "there is no ninth view";
  press_key(s, '7');
  EXPECT_EQ(s.view, MatteView::Labels);
  press_key(s, 'V');
  EXPECT_EQ(s.view, MatteView::Photograph);
  press_key(s, 'G');
  EXPECT_EQ(s.session.tool, EditTool::Garbage);
  press_key(s, 'H');
  EXPECT_EQ(s.session.tool, EditTool::HoldOut);
  press_key(s, 'F');
  EXPECT_EQ(s.session.tool, EditTool::Stroke);
  const double radius = s.session.radius;
  press_key(s, ']');
  EXPECT_GT(s.session.radius, radius);
  press_key(s, '[');
  EXPECT_LE(s.session.radius, radius);
}

TEST(EditorInput, MovesThroughTheClip) {
  EditorState s = state();
  press_key(s, kKeyRight);
  EXPECT_EQ(s.time.frame(), 1);
  press_key(s, kKeyEnd);
  EXPECT_EQ(s.time.frame(), 19);
  press_key(s, kKeyLeft);
  EXPECT_EQ(s.time.frame(), 18);
  press_key(s, kKeyHome);
  EXPECT_EQ(s.time.frame(), 0);
  press_key(s, ' ');
  EXPECT_TRUE(s.time.playing);
  drag(s, 400, 100, 400, 100);
  EXPECT_FALSE(s.time.playing) << "who draws looks at one frame";
}

TEST(EditorInput, RemovesTheKeyframeHere) {
  EditorState s = state();
  drag(s, 400, 100, 400, 100);
  EXPECT_TRUE(press_key(s, kKeyDelete).edited);
  EXPECT_EQ(s.session.edits(), CameraEdits());
  EXPECT_FALSE(press_key(s, kKeyDelete).edited);
  EXPECT_NE(s.status.find("no keyframe"), std::string::npos);
}

TEST(EditorInput, HandsOnWhatItCannotDo) {
  EditorState s = state();
  EXPECT_TRUE(press_key(s, kKeyEnter).remake);
  EXPECT_TRUE(press_key(s, kKeyTab).next_camera);
  EXPECT_TRUE(press_key(s, 'M').player);
  EXPECT_TRUE(press_key(s, kKeyF12).screenshot);
  EXPECT_TRUE(press_key(s, 'Q', true).quit);
  EXPECT_FALSE(press_key(s, 'Q').quit);
  press_key(s, 'A');
  EXPECT_FALSE(s.automatic);
  take_input(at(InputEvent::Kind::Press, 400, 100), s);
  press_key(s, kKeyEscape);
  EXPECT_EQ(s.session.drawing(), nullptr);
}

}  // namespace
}  // namespace floatstage::apps
