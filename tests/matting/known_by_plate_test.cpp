#include "matting/known_by_plate.h"

#include <algorithm>

#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

constexpr int kW = 64, kH = 48;

// A wall of one grey, and before it somebody in another colour: a square from 20 to 39 in x and y.
class KnownByPlate : public testing::Test {
 protected:
  KnownByPlate() : picture_(kW, kH, 3, 120), cut_(kW / 2, kH / 2, 1), odds_(cut_.pixels.size(), -1) {
    plate_ = *learn_plate({picture_});
    paint(20, 40, 20, 40, {170, 90, 80});
    for (int y = 10; y < 20; ++y) std::fill_n(cut_.at(10, y), 10, std::uint8_t{255});
  }
  void paint(int x0, int x1, int y0, int y1, std::array<std::uint8_t, 3> color) {
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) std::copy(color.begin(), color.end(), picture_.at(x, y));
  }
  // The subject is likely there, as its own pixels have it.
  void likely(int x0, int x1, int y0, int y1) {
    for (int y = y0 / 2; y < y1 / 2; ++y)
      for (int x = x0 / 2; x < x1 / 2; ++x)
        odds_[static_cast<std::size_t>(y) * (kW / 2) + static_cast<std::size_t>(x)] = 3;
  }
  Image known() const { return known_by_plate(word_of(plate_, picture_), cut_, odds_); }

  Plate plate_;
  Image picture_, cut_;
  std::vector<float> odds_;
};

TEST_F(KnownByPlate, SubjectAndWallAreKnownAndTheOutlineIsLeftOpen) {
  const Image map = known();
  EXPECT_EQ(*map.at(30, 30), 255);
  EXPECT_EQ(*map.at(21, 30), 255) << "one pixel from the outline";
  EXPECT_EQ(*map.at(20, 30), 128);
  EXPECT_EQ(*map.at(19, 30), 128);
  EXPECT_EQ(*map.at(18, 30), 0);
  EXPECT_EQ(*map.at(2, 2), 0);
}

TEST_F(KnownByPlate, AHandThatTheCutMissedIsFoundWhereItIsLikely) {
  paint(40, 46, 28, 34, {170, 90, 80});
  EXPECT_EQ(*known().at(43, 31), 128) << "a coloured shadow would look the same";
  likely(40, 46, 28, 34);
  EXPECT_EQ(*known().at(43, 31), 255);
}

TEST_F(KnownByPlate, HairThroughWhichTheWallShowsIsLeftOpen) {
  for (int x = 24; x < 36; x += 2) paint(x, x + 1, 20, 40, {138, 111, 108});  // a third of it
  EXPECT_EQ(*known().at(28, 30), 128);
  EXPECT_EQ(*known().at(29, 30), 255) << "between such strands";
}

TEST_F(KnownByPlate, AFingerIsSeenInASmallerPictureAndAStrandIsNot) {
  paint(43, 46, 4, 14, {170, 90, 80});
  paint(51, 52, 4, 14, {170, 90, 80});
  const Image small = unlike_within(word_of(plate_, picture_), kW / 2, kH / 2);
  EXPECT_EQ(*small.at(22, 4), 255);
  EXPECT_EQ(*small.at(25, 4), 0);
}

TEST_F(KnownByPlate, WhatIsFarFromTheCutIsNotItsOutline) {
  paint(50, 60, 20, 30, {20, 200, 20});  // somebody left a ball there
  likely(50, 60, 20, 30);
  EXPECT_EQ(*known().at(55, 25), 128);
}

TEST_F(KnownByPlate, AShadowIsLeftOpen) {
  paint(20, 40, 40, 46, {80, 80, 80});
  likely(20, 40, 40, 46);
  EXPECT_EQ(*known().at(30, 43), 128);
}

TEST_F(KnownByPlate, ClothesOfTheWallsColourAreTheCutsToTell) {
  paint(22, 38, 22, 38, {120, 120, 120});
  EXPECT_EQ(*known().at(30, 30), 128);
}

}  // namespace
}  // namespace floatstage::matting
