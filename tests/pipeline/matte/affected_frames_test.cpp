#include "pipeline/matte/affected_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage::pipeline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr int kFrames = 12;

MatteKeyframe key(int frame, double x = 5) { return {frame, {{MatteLabel::Foreground, 3, {{x, 5}}}}}; }

MatteMask mask(int first, std::optional<int> last) {
  return {MatteLabel::Background, {{0, 0}, {9, 0}, {9, 9}}, first, last};
}

std::vector<int> listed(const std::vector<bool>& frames) {
  std::vector<int> out;
  for (std::size_t f = 0; f < frames.size(); ++f)
    if (frames[f]) out.push_back(static_cast<int>(f));
  return out;
}

std::vector<int> all() { return listed(std::vector<bool>(kFrames, true)); }

TEST(FramesBetweenKeyframes, ReachToTheKeyframesOnEitherSide) {
  const CameraEdits before{{key(1), key(9)}, {}};
  EXPECT_THAT(listed(frames_between_keyframes(before, {{key(1), key(4), key(9)}, {}}, kFrames)),
              ElementsAre(2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(listed(frames_between_keyframes({{key(1), key(4), key(9)}, {}}, before, kFrames)),
              ElementsAre(2, 3, 4, 5, 6, 7, 8))
      << "undone";
  EXPECT_THAT(listed(frames_between_keyframes(before, {{key(1), key(9, 7)}, {}}, kFrames)),
              ElementsAre(2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
  EXPECT_THAT(listed(frames_between_keyframes(before, {{key(1, 7), key(9)}, {}}, kFrames)),
              ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(listed(frames_between_keyframes(before, before, kFrames)), IsEmpty());
}

TEST(FramesBetweenKeyframes, AreAllWhenTheFirstComesOrTheLastGoes) {
  EXPECT_EQ(listed(frames_between_keyframes({}, {{key(4)}, {}}, kFrames)), all());
  EXPECT_EQ(listed(frames_between_keyframes({{key(4)}, {}}, {}, kFrames)), all());
  EXPECT_THAT(listed(frames_between_keyframes({}, {{{4, {}}}, {}}, kFrames)), IsEmpty())
      << "a keyframe that says nothing is none";
}

TEST(FramesBetweenKeyframes, CountAMaskWhereItHoldsOnly) {
  const CameraEdits before{{key(1)}, {mask(2, 4)}};
  EXPECT_THAT(listed(frames_between_keyframes(before, {{key(1)}, {mask(2, 6)}}, kFrames)), ElementsAre(5, 6));
  EXPECT_THAT(listed(frames_between_keyframes(before, {{key(1)}, {}}, kFrames)), ElementsAre(2, 3, 4));
  EXPECT_THAT(listed(frames_between_keyframes(before, {{key(1)}, {mask(2, 4), mask(10, {})}}, kFrames)),
              ElementsAre(10, 11));
}

TEST(FramesThatEditsConcern, AreNoneWhereOnlyWhoseAStrokeIsHasChanged) {
  const CameraEdits before{{key(1), key(9)}, {}};
  CameraEdits after = before;
  after.keyframes[0].strokes[0].subject = "woman";
  EXPECT_TRUE(same_strokes(before, after));
  EXPECT_EQ(seed_of(before), seed_of(after));
  EXPECT_THAT(listed(edited_frames(before, after, kFrames)), IsEmpty());
  for (const char* method : {"key", "closed-form", "spectral", "consistent"})
    for (const char* made_from : {"chroma", "cut"})
      EXPECT_THAT(listed(frames_made_otherwise(method, made_from, before, after, kFrames)), IsEmpty());
}

TEST(FramesChosenOtherwise, AreThoseWithOtherStrokesOrMasks) {
  const CameraEdits before{{key(1), key(9)}, {}};
  EXPECT_THAT(listed(frames_chosen_otherwise(before, {{key(1), key(4), key(9)}, {mask(7, 7)}}, kFrames)),
              ElementsAre(4, 6, 7, 8))
      << "what is carried on from a frame is what strokes made of what its masks leave";
  EXPECT_THAT(listed(frames_chosen_otherwise({}, {{}, {mask(7, {})}}, kFrames)), ElementsAre(7, 8, 9, 10, 11))
      << "nobody chooses: each for itself";
  EXPECT_EQ(listed(frames_chosen_otherwise({}, {{key(3)}, {}}, kFrames)), all());
}

TEST(FramesChosenOtherwise, HoldThoseThatFollowAnotherNeighbourNow) {
  EXPECT_THAT(
      listed(frames_chosen_otherwise({{key(5), key(9)}, {}}, {{key(2), key(5), key(9)}, {}}, kFrames)),
      ElementsAre(2, 3, 4, 5));
}

TEST(Downstream, GoesFromTheFirstKeyframeBothWays) {
  const CameraEdits edits{{key(4), key(9)}, {}};
  std::vector<bool> frames(kFrames);
  frames[7] = true;
  EXPECT_THAT(listed(downstream_of(frames, edits)), ElementsAre(7, 8, 9, 10, 11));
  frames.assign(kFrames, false), frames[2] = true;
  EXPECT_THAT(listed(downstream_of(frames, edits)), ElementsAre(0, 1, 2));
  frames.assign(kFrames, false), frames[4] = true;
  EXPECT_EQ(listed(downstream_of(frames, edits)), all());
  EXPECT_THAT(listed(downstream_of(frames, {})), ElementsAre(4));
  EXPECT_THAT(downstream_of({}, edits), IsEmpty());
}

}  // namespace
}  // namespace floatstage::pipeline
