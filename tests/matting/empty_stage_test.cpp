#include "matting/keyers/empty_stage.h"

#include <algorithm>

#include "tests/matting/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

constexpr int kWide = 160, kHigh = 120;

struct Patch {
  int left, top, right, bottom;  // the last two not included
  Rgb color;
};

void paint(Image& picture, const Patch& patch) {
  for (int y = patch.top; y < patch.bottom; ++y)
    for (int x = patch.left; x < patch.right; ++x) {
      picture.at(x, y)[0] = patch.color.r;
      picture.at(x, y)[1] = patch.color.g;
      picture.at(x, y)[2] = patch.color.b;
    }
}

void mark(Image& mask, const Patch& patch, std::uint8_t value) {
  for (int y = patch.top; y < patch.bottom; ++y)
    for (int x = patch.left; x < patch.right; ++x) *mask.at(x, y) = value;
}

// Green cloth with a lamp before it; somebody in red stands beside the lamp, in black shoes, and throws a
// shadow.
const Rgb kCloth{40, 120, 60};
const Patch kLamp{20, 10, 40, 30, {250, 250, 240}};
const Patch kBody{60, 20, 90, 90, {180, 60, 50}};
const Patch kShoes{60, 90, 90, 105, {6, 9, 7}};
const Patch kShadow{95, 80, 130, 105, {18, 54, 27}};

Image stage_with(const std::vector<Patch>& patches) {
  Image picture(kWide, kHigh, 3);
  paint(picture, {0, 0, kWide, kHigh, kCloth});
  for (const Patch& patch : patches) paint(picture, patch);
  return picture;
}

Image mask_of(const std::vector<Patch>& patches) {
  Image mask(kWide, kHigh, 1);
  for (const Patch& patch : patches) mark(mask, patch, 255);
  return mask;
}

EmptyStage with_a_lamp() {
  Result<Plate> plate = learn_plate({stage_with({kLamp})});
  EXPECT_THAT(plate, IsOk());
  return EmptyStage(std::move(*plate), mask_of({kLamp}), 0.01);
}

TEST(EmptyStage, TakesOutWhatItsKeyTookForSubject) {
  Image key = mask_of({kLamp, kBody});
  EXPECT_TRUE(with_a_lamp().take_out_fixtures(stage_with({kLamp, kBody, kShoes}), key));
  EXPECT_TRUE(key == mask_of({kBody}));
}

TEST(EmptyStage, LeavesWhoeverStandsBeforeALamp) {
  const Patch before{25, 5, 55, 90, {180, 60, 50}};
  Image key = mask_of({kLamp, before});
  with_a_lamp().take_out_fixtures(stage_with({kLamp, before}), key);
  EXPECT_TRUE(key == mask_of({before}));
}

TEST(EmptyStage, LeavesAKeyItsBytesWhereNoFixtureShows) {
  Image key = mask_of({kBody});
  *key.at(100, 60) = 40;  // a faint part that clean-up would drop
  const Image before = key;
  with_a_lamp().take_out_fixtures(stage_with({kLamp, kBody}), key);
  EXPECT_TRUE(key == before);
}

TEST(EmptyStage, DoesNothingToAPictureOfAnotherSize) {
  Image key(10, 10, 1, 255);
  EXPECT_FALSE(with_a_lamp().take_out_fixtures(Image(10, 10, 3), key));
  EXPECT_EQ(*key.at(5, 5), 255);
}

TEST(EmptyStage, KnowsBlackShoesAndClothesInTheClothsHueFromAShadow) {
  const Patch sleeve{60, 5, 90, 20, {60, 210, 90}};  // green, but twice as bright as any reflex of the cloth
  const Image solid = with_a_lamp().solid(stage_with({kLamp, kBody, kShoes, kShadow, sleeve}));
  EXPECT_TRUE(solid == mask_of({kBody, kShoes, sleeve}));
}

TEST(EmptyStage, TellsHowMuchOfItsFixturesAPhotographShows) {
  EXPECT_EQ(with_a_lamp().fixtures_shown(stage_with({kLamp, kBody})), 1);
  const Patch half{20, 10, 30, 30, {180, 60, 50}};
  EXPECT_EQ(with_a_lamp().fixtures_shown(stage_with({kLamp, half})), 0.5);
  EXPECT_EQ(with_a_lamp().fixtures_shown(stage_with({})), 0);
}

TEST(EmptyStage, SeesNobodyInItself) {
  const Image solid = with_a_lamp().solid(stage_with({kLamp}));
  EXPECT_EQ(*std::max_element(solid.pixels.begin(), solid.pixels.end()), 0);
}

TEST(EmptyStage, CorrectsAKeyWithoutALampAndWithWholeShoes) {
  Image key = mask_of({kLamp, kBody});
  EXPECT_TRUE(with_a_lamp().correct(stage_with({kLamp, kBody, kShoes, kShadow}), key));
  EXPECT_TRUE(key == mask_of({kBody, kShoes}));
}

TEST(EmptyStage, AddsNothingThatStandsByItself) {
  const Patch chair{120, 20, 140, 60, {180, 60, 50}};  // nobody knows whose it is
  Image key = mask_of({kBody});
  EXPECT_TRUE(with_a_lamp().correct(stage_with({kLamp, kBody, chair}), key));
  EXPECT_TRUE(key == mask_of({kBody}));
}

TEST(EmptyStage, IsNotHeardWhereItTellsMoreThanTheKey) {
  Image other = stage_with({kLamp, kBody});
  for (std::uint8_t& v : other.pixels) v = static_cast<std::uint8_t>(v / 5);  // the light is out
  Image key = mask_of({kBody});
  EXPECT_FALSE(with_a_lamp().correct(other, key));
  EXPECT_TRUE(key == mask_of({kBody}));
}

TEST(EmptyStage, WhatIsInsideIsAwayFromTheOutline) {
  const Image inside = EmptyStage::inside(mask_of({kBody}));
  EXPECT_EQ(*inside.at(75, 55), 255);
  EXPECT_EQ(*inside.at(kBody.left + 1, 55), 0);
  EXPECT_EQ(*inside.at(kBody.left - 1, 55), 0);
}

}  // namespace
}  // namespace floatstage::matting
