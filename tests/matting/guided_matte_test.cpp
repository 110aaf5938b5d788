#include "matting/guide/guided_matte.h"

#include <algorithm>

#include "core/random.h"
#include "tests/matting/drawn_strokes.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"

namespace floatstage::matting {
namespace {

constexpr int kWidth = 160, kHeight = 120;

struct Color {
  int r, g, b;
};
constexpr Color kWall{120, 130, 110}, kShirt{190, 40, 40}, kSkin{220, 170, 140}, kHair{20, 18, 16};

// Flat things with a little noise, and who of them is subject.
struct GuidedScene {
  Image picture{kWidth, kHeight, 3}, truth{kWidth, kHeight, 1};
  Random random{7};

  GuidedScene() { paint({0, 0, kWidth, kHeight}, kWall, false); }
  struct Box {
    int x0, y0, x1, y1;
  };
  void paint(const Box& box, const Color& color, bool subject) {
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x) {
        const int c[] = {color.r, color.g, color.b};
        for (int i = 0; i < 3; ++i)
          picture.at(x, y)[i] = static_cast<std::uint8_t>(std::clamp(c[i] + random.normal() * 3, 0.0, 255.0));
        *truth.at(x, y) = subject ? 255 : 0;
      }
  }
};
constexpr GuidedScene::Box kTorso{60, 40, 100, 110}, kArm{100, 50, 145, 64};

GuidedScene person() {
  GuidedScene s;
  s.paint(kTorso, kShirt, true);
  s.paint(kArm, kSkin, true);
  return s;
}
void fill(Image& matte, const GuidedScene::Box& box, std::uint8_t value) {
  for (int y = box.y0; y < box.y1; ++y) std::fill_n(matte.at(box.x0, y), box.x1 - box.x0, value);
}
MatteStroke click(MatteLabel label, double x, double y, double radius = 2) {
  return {label, radius, {{x, y}}};
}

TEST(GuidedMatte, IsTheMatteWhenNobodySaysAnything) {
  const GuidedScene s = person();
  EXPECT_EQ(guided_matte(s.picture, s.truth, {})->matte, s.truth);
}

TEST(GuidedMatte, AClickOnAMissingArmBringsTheArm) {
  const GuidedScene s = person();
  Image matte = s.truth;
  fill(matte, kArm, 0);
  const auto made = guided_matte(s.picture, matte, {click(MatteLabel::Foreground, 125, 57)});
  ASSERT_THAT(made, IsOk());
  EXPECT_GE(overlap(made->matte, s.truth), 0.99);
  EXPECT_EQ(made->effects, std::vector{StrokeEffect::Acted});
}

TEST(GuidedMatte, AClickOnWallThatWasTakenAlongSendsItAway) {
  const GuidedScene s = person();
  Image matte = s.truth;
  fill(matte, {100, 64, 130, 100}, 255);
  const auto made = guided_matte(s.picture, matte, {click(MatteLabel::Background, 115, 80)});
  ASSERT_THAT(made, IsOk());
  EXPECT_GE(overlap(made->matte, s.truth), 0.99);
}

TEST(GuidedMatte, AnIslandThatIsMarkedInItsMiddleGoesAsAWholeAndAClickOnASubjectDropsNobody) {
  GuidedScene s = person();
  s.paint({10, 40, 30, 110}, kShirt, false);  // somebody else, in the same shirt and other trousers
  s.paint({10, 80, 30, 110}, kHair, false);
  Image matte = s.truth;
  fill(matte, {10, 40, 30, 110}, 255);
  EXPECT_EQ(guided_matte(s.picture, matte, {click(MatteLabel::Foreground, 80, 70)})->matte, matte);
  EXPECT_EQ(guided_matte(s.picture, matte, {click(MatteLabel::Background, 20, 70)})->matte, s.truth);
}

TEST(GuidedMatte, HairStaysWhenAStickBeforeTheSameBlackWallIsTakenAway) {
  GuidedScene s;
  s.paint({0, 0, kWidth, 60}, kHair, false);  // a black wall …
  s.paint({60, 50, 100, 110}, kShirt, true);
  s.paint({66, 20, 94, 50}, kHair, true);  // … and black hair before it
  Image matte = s.truth;
  fill(matte, {78, 4, 82, 20}, 255);
  const double before = overlap(matte, s.truth);
  const auto made = guided_matte(s.picture, matte, {click(MatteLabel::Background, 80, 9, 1.5)});
  ASSERT_THAT(made, IsOk());
  EXPECT_GE(overlap(made->matte, s.truth), before) << "what is much thicker than where it was clicked stays";
  EXPECT_EQ(*made->matte.at(80, 9), 0);
  EXPECT_EQ(*made->matte.at(80, 35), 255);
}

TEST(GuidedMatte, ChangesNothingFarFromWhatTurns) {
  const GuidedScene s = person();
  Image matte = s.truth;
  fill(matte, kArm, 0);
  for (int y = 0; y < kHeight; ++y) *matte.at(59, y) = 77;  // softness of another maker
  const auto made = guided_matte(s.picture, matte, {click(MatteLabel::Foreground, 125, 57)});
  ASSERT_THAT(made, IsOk());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < 90; ++x) ASSERT_EQ(*made->matte.at(x, y), *matte.at(x, y)) << x << ' ' << y;
}

TEST(GuidedMatte, SaysWhatCannotAct) {
  const GuidedScene s = person();
  const auto made =
      guided_matte(s.picture, s.truth,
                   {click(MatteLabel::Foreground, 80, 70), click(MatteLabel::Background, -50, 70),
                    click(MatteLabel::Background, 20, 20), click(MatteLabel::Background, 80, 70)});
  ASSERT_THAT(made, IsOk());
  EXPECT_EQ(made->effects, (std::vector{StrokeEffect::Already, StrokeEffect::Outside, StrokeEffect::Already,
                                        StrokeEffect::Acted}));
  EXPECT_EQ(*made->matte.at(80, 70), 0) << "a stroke always changes the matte where it is";
  Image mask(kWidth, kHeight, 1, 128);
  fill(mask, kTorso, 255);
  const auto masked = guided_matte(s.picture, s.truth, {click(MatteLabel::Background, 80, 70)}, mask);
  ASSERT_THAT(masked, IsOk());
  EXPECT_EQ(masked->effects, std::vector{StrokeEffect::Already}) << "a mask outranks strokes";
  EXPECT_EQ(masked->matte, s.truth);
}

TEST(GuidedMatte, WhatOneStrokeSaidStaysWithTheNext) {
  const GuidedScene s = person();
  const std::vector<MatteStroke> said = {click(MatteLabel::Foreground, 110, 57),
                                         click(MatteLabel::Background, 130, 57)};
  const auto made = guided_matte(s.picture, s.truth, said);
  ASSERT_THAT(made, IsOk());
  EXPECT_EQ(*made->matte.at(110, 57), 255);
  EXPECT_EQ(*made->matte.at(130, 57), 0);
}

TEST(GuidedMatte, RefusesSizesThatDoNotFit) {
  const GuidedScene s = person();
  EXPECT_THAT(guided_matte(s.picture, Image(10, 10, 1), {}), FailsWith(ErrorCode::InvalidArgument, "size"));
  EXPECT_THAT(guided_matte(s.truth, s.truth, {}), FailsWith(ErrorCode::InvalidArgument, "RGB"));
  EXPECT_THAT(guided_matte(s.picture, s.truth, {}, Image(3, 3, 1)),
              FailsWith(ErrorCode::InvalidArgument, "size"));
}

TEST(GuidedMatte, EverywhereOnePixelOfTheOtherSideOrNoneIsNoTrouble) {
  const GuidedScene s = person();
  for (const int fill_with : {0, 255}) {
    const Image all(kWidth, kHeight, 1, static_cast<std::uint8_t>(fill_with));
    for (const MatteLabel label : {MatteLabel::Foreground, MatteLabel::Background})
      EXPECT_THAT(guided_matte(s.picture, all, {click(label, 80, 70), click(label, 0.5, 0.5, 400)}), IsOk());
  }
}

// The person walks 3 px a frame to the right.
TEST(CarriedGuidance, FollowsWhatWasChangedForAsLongAsTheFaultIsThere) {
  const auto at = [](int shift) {
    GuidedScene s;
    s.paint({60 + shift, 40, 100 + shift, 110}, kShirt, true);
    s.paint({60 + shift, 15, 84 + shift, 40}, kSkin, true);
    for (int y = 20; y < 36; y += 4) s.paint({62 + shift, y, 70 + shift + y / 4, y + 2}, kHair, true);
    return s;
  };
  const GuidedScene before = at(0), now = at(3);
  Image fault = before.truth, fault_now = now.truth;
  fill(fault, {60, 15, 84, 40}, 0);
  fill(fault_now, {63, 15, 87, 40}, 0);
  const auto first = guided_matte(before.picture, fault, {click(MatteLabel::Foreground, 72, 30, 6)});
  ASSERT_THAT(first, IsOk());
  ASSERT_GE(overlap(first->matte, before.truth), 0.98);
  const CarriedGuidance carried =
      carried_guidance(before.picture, fault, first->matte, now.picture, fault_now);
  const auto made = guided_matte(now.picture, fault_now, {}, {}, carried);
  ASSERT_THAT(made, IsOk());
  EXPECT_GE(overlap(made->matte, now.truth), 0.97);
  const CarriedGuidance healed =
      carried_guidance(before.picture, fault, first->matte, now.picture, now.truth);
  EXPECT_EQ(guided_matte(now.picture, now.truth, {}, {}, healed)->matte, now.truth);
  EXPECT_TRUE(carried_guidance(before.picture, fault, fault, now.picture, fault_now).said.empty());
}

// What carried guidance brought and what the matte does not show.
TEST(EndedChanges, AreFaultsThatStoodCorrectedInTheNeighbour) {
  const GuidedScene s = person();
  Image fault = s.truth;
  constexpr GuidedScene::Box kOther{5, 5, 25, 25};
  fill(fault, kOther, 255);
  fill(fault, kArm, 0);
  CarriedGuidance carried;
  carried.said = carried.followed = Image(kWidth, kHeight, 1, 128);
  fill(carried.followed, kOther, 0);
  fill(carried.followed, kArm, 255);
  const Image nothing(kWidth, kHeight, 1, 128);
  const std::vector<EndedChange> both = ended_changes(carried, fault, fault, nothing);
  ASSERT_EQ(both.size(), 2U) << "nothing has followed them";
  EXPECT_EQ(both[0].said, MatteLabel::Foreground) << "the larger one first";
  EXPECT_LE((both[0].at - Eigen::Vector2d(122.5, 57)).norm(), 1.5) << both[0].at;
  EXPECT_EQ(both[1].said, MatteLabel::Background);
  EXPECT_TRUE(ended_changes(carried, fault, s.truth, nothing).empty()) << "both were followed";
  EXPECT_TRUE(ended_changes(carried, s.truth, s.truth, nothing).empty()) << "the fault itself has ended";
  Image contrary = nothing;
  fill(contrary, {10, 10, 12, 12}, 255);
  EXPECT_EQ(ended_changes(carried, fault, fault, contrary).size(), 1U) << "somebody wants it back";
  EXPECT_TRUE(ended_changes({}, fault, fault, nothing).empty());
}

// The person's arm was given back in the frame before; then a board hides all of it.
TEST(EndedChanges, AreWhatSomethingElseHides) {
  const GuidedScene before = person();
  GuidedScene now = before;
  now.paint({100, 36, 156, 80}, kHair, false);
  Image fault = before.truth;
  fill(fault, kArm, 0);
  const CarriedGuidance carried = carried_guidance(before.picture, fault, before.truth, now.picture, fault);
  const auto made = guided_matte(now.picture, fault, {}, {}, carried);
  ASSERT_THAT(made, IsOk());
  EXPECT_FALSE(ended_changes(carried, fault, made->matte, Image(kWidth, kHeight, 1, 128)).empty());
}

// A stroke that is right never makes a matte worse by more than 0.01, and always acts where it is. More
// scenes, real ones too, in guide_real_test.cpp.
TEST(RightStrokes, NeverMakeAMatteWorse) {
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    const Image place = seed % 2 ? green_cloth(180, 120, seed) : cluttered_place(180, 120, seed);
    const MatteClip clip = make_clip(studio_cutout(seed, 120, 120), place,
                                     {.width = 180, .height = 120, .frames = 1, .seed = seed, .scale = 0.7});
    Random random(seed);
    const Image base = doubtful_matte(clip.frames[0], clip.truth[0], random);
    StrokeDrawer drawer(clip.truth[0], seed);
    std::vector<MatteStroke> said;
    Image now = base;
    for (int i = 0; i < 5; ++i) {
      said.push_back(drawer.next(now));
      const auto made = guided_matte(clip.frames[0], base, said);
      ASSERT_THAT(made, IsOk());
      EXPECT_GE(overlap(made->matte, clip.truth[0]), overlap(now, clip.truth[0]) - 0.01)
          << "seed " << seed << ", stroke " << i;
      EXPECT_TRUE(made->effects.back() == StrokeEffect::Acted || made->matte == now)
          << "said to change nothing";
      Image print(180, 120, 1, 128);
      paint_strokes({said.back()}, 1, print);
      for (std::size_t p = 0; p < print.pixels.size(); ++p)
        ASSERT_EQ(made->matte.pixels[p], print.pixels[p] == 128 ? made->matte.pixels[p] : print.pixels[p]);
      now = made->matte;
    }
  }
}

}  // namespace
}  // namespace floatstage::matting
