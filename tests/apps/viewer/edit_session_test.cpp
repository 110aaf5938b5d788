#include "apps/viewer/mattes/edit_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage::apps {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

EditSession session() { return EditSession({}, 20, 160, 120); }

void draw(EditSession& s, int frame, const std::vector<Eigen::Vector2d>& points, bool second = false) {
  s.press(frame, points.front(), second);
  for (std::size_t i = 1; i < points.size(); ++i) s.drag(points[i]);
  s.release();
}

TEST(EditSession, MakesAClickOfAPressAndAScribbleOfADrag) {
  EditSession s = session();
  draw(s, 7, {{80.1, 60}});
  draw(s, 7, {{10, 10}, {10.3, 10}, {20, 10}, {30, 15}}, true);
  ASSERT_EQ(s.edits().keyframes.size(), 1u);
  const MatteKeyframe& k = s.edits().keyframes[0];
  EXPECT_EQ(k.frame, 7);
  ASSERT_EQ(k.strokes.size(), 2u);
  EXPECT_EQ(k.strokes[0], (MatteStroke{MatteLabel::Foreground, s.radius, {{80, 60}}}))
      << "to a quarter of a pixel";
  EXPECT_EQ(k.strokes[1], (MatteStroke{MatteLabel::Background, s.radius, {{10, 10}, {20, 10}, {30, 15}}}))
      << "points closer than a pixel say nothing";
}

TEST(EditSession, NamesStrokesOfTheSubjectAndNothingElse) {
  EditSession s = session();
  s.subject = "woman";
  draw(s, 7, {{80, 60}});
  draw(s, 7, {{10, 10}}, true);
  s.tool = EditTool::HoldOut;
  draw(s, 7, {{50, 50}});
  s.tool = EditTool::Stroke;
  s.subject = "";
  draw(s, 7, {{90, 60}});
  const std::vector<MatteStroke>& strokes = s.edits().keyframes.at(0).strokes;
  ASSERT_EQ(strokes.size(), 3u);
  EXPECT_EQ(strokes[0].subject, "woman");
  EXPECT_EQ(strokes[1].subject, "") << "background is nobody's";
  EXPECT_EQ(strokes[2].subject, "");
  EXPECT_EQ(s.edits().masks.size(), 1u);
}

TEST(EditSession, KeepsKeyframesInTheOrderOfTheirFrames) {
  EditSession s = session();
  for (int frame : {9, 2, 5}) draw(s, frame, {{50, 50}});
  std::vector<int> frames;
  for (const MatteKeyframe& k : s.edits().keyframes) frames.push_back(k.frame);
  EXPECT_THAT(frames, ElementsAre(2, 5, 9));
  EXPECT_EQ(s.keyframe_after(2), 5);
  EXPECT_EQ(s.keyframe_after(9), std::nullopt);
  EXPECT_EQ(s.keyframe_before(9), 5);
  EXPECT_EQ(s.keyframe_before(2), std::nullopt);
  EXPECT_NE(s.keyframe(5), nullptr);
  EXPECT_EQ(s.keyframe(6), nullptr);
}

TEST(EditSession, KeepsNothingBeforeTheHandLetsGo) {
  EditSession s = session();
  s.press(0, {5, 5}, false);
  s.drag({15, 5});
  ASSERT_NE(s.drawing(), nullptr);
  EXPECT_EQ(s.drawing()->points.size(), 2u);
  EXPECT_EQ(s.edits(), CameraEdits());
  s.give_up();
  EXPECT_FALSE(s.release());
  EXPECT_EQ(s.edits(), CameraEdits());
  EXPECT_FALSE(s.can_undo());
}

TEST(EditSession, DropsStrokesBesideThePhotograph) {
  EditSession s = session();
  draw(s, 0, {{-300, 20}, {-290, 20}});
  EXPECT_EQ(s.edits(), CameraEdits());
  draw(s, 0, {{-30, 20}, {30, 20}});
  EXPECT_EQ(s.edits().keyframes.size(), 1u) << "it comes in";
}

TEST(EditSession, PaintsGarbageForTheWholeClipOrFromHereOrHere) {
  EditSession s = session();
  s.tool = EditTool::Garbage;
  s.radius = 6;
  draw(s, 4, {{20, 20}, {40, 20}});
  s.mask_reach = MaskReach::FromHere;
  draw(s, 4, {{60, 20}});
  s.mask_reach = MaskReach::ThisFrame;
  s.tool = EditTool::HoldOut;
  draw(s, 4, {{90, 90}});
  EXPECT_THAT(s.edits().keyframes, IsEmpty());
  EXPECT_THAT(s.edits().masks, ElementsAre(MatteMask{MatteLabel::Background, {{20, 20}, {40, 20}}, 0, {}, 6},
                                           MatteMask{MatteLabel::Background, {{60, 20}}, 4, {}, 6},
                                           MatteMask{MatteLabel::Foreground, {{90, 90}}, 4, 4, 6}));
}

TEST(EditSession, RemovesTheUppermostMaskUnderTheRightButton) {
  EditSession s = session();
  s.tool = EditTool::Garbage;
  s.radius = 6;
  draw(s, 4, {{20, 20}});
  draw(s, 4, {{24, 20}});
  EXPECT_FALSE(s.press(4, {100, 100}, true)) << "nothing is there";
  EXPECT_TRUE(s.press(4, {22, 20}, true));
  ASSERT_EQ(s.edits().masks.size(), 1u);
  EXPECT_EQ(s.edits().masks[0].polygon[0].x(), 20);
  EXPECT_TRUE(s.undo());
  EXPECT_EQ(s.edits().masks.size(), 2u);
}

TEST(EditSession, UndoesAndRedoesEveryStepOnce) {
  EditSession s = session();
  std::vector<CameraEdits> history{s.edits()};
  draw(s, 3, {{50, 50}}), history.push_back(s.edits());
  draw(s, 3, {{10, 50}}, true), history.push_back(s.edits());
  s.tool = EditTool::Garbage;
  draw(s, 3, {{10, 50}}), history.push_back(s.edits());
  EXPECT_TRUE(s.remove_keyframe(3));
  history.push_back(s.edits());
  EXPECT_TRUE(s.clear());
  history.push_back(s.edits());
  EXPECT_FALSE(s.clear()) << "nothing to clear is no step";
  EXPECT_FALSE(s.remove_keyframe(11));
  for (std::size_t i = history.size() - 1; i-- > 0;) {
    ASSERT_TRUE(s.undo());
    EXPECT_EQ(s.edits(), history[i]) << i;
  }
  EXPECT_FALSE(s.undo());
  for (std::size_t i = 1; i < history.size(); ++i) {
    ASSERT_TRUE(s.redo());
    EXPECT_EQ(s.edits(), history[i]) << i;
  }
  EXPECT_FALSE(s.redo());
  ASSERT_TRUE(s.undo());
  draw(s, 8, {{60, 60}});
  EXPECT_FALSE(s.can_redo()) << "another way was taken";
}

TEST(EditSession, KeepsTheBrushWithinReason) {
  EditSession s = session();
  EXPECT_GE(s.radius, 0.5);
  for (int i = 0; i < 50; ++i) s.grow(0.5);
  EXPECT_EQ(s.radius, 0.5);
  for (int i = 0; i < 50; ++i) s.grow(2);
  EXPECT_EQ(s.radius, 500);
}

TEST(WorstFrames, AreThePeaksOfTheFlickerWorstFirst) {
  EXPECT_THAT(worst_frames({std::nullopt, 0.01, 0.05, 0.02, 0.02, 0.3, 0.25, std::nullopt, 0.1}),
              ElementsAre(5, 8, 2));
  EXPECT_THAT(worst_frames({std::nullopt, 0.2, 0.2, 0.001}), ElementsAre(1)) << "of equal ones the first";
  EXPECT_THAT(worst_frames({0.0, 0.0}), IsEmpty());
  EXPECT_THAT(worst_frames({}), IsEmpty());
}

TEST(WorstFrames, AreVisitedInTurn) {
  const std::vector<int> worst = {5, 8, 2};
  EXPECT_EQ(next_worst(worst, 0), 5);
  EXPECT_EQ(next_worst(worst, 5), 8);
  EXPECT_EQ(next_worst(worst, 8), 2);
  EXPECT_EQ(next_worst(worst, 2), 5) << "and again";
  EXPECT_EQ(next_worst({}, 2), std::nullopt);
}

}  // namespace
}  // namespace floatstage::apps
