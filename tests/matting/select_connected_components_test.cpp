#include "matting/select_connected_components.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace floatstage::matting {
namespace {

// Boxes of opacity in 80x60: the subject at left, somebody else at right.
void paint(Image& image, int x0, int y0, int x1, int y1, std::uint8_t value = 255) {
  for (int y = y0; y < y1; ++y) std::fill_n(image.at(x0, y), x1 - x0, value);
}
Image two_people(int shift = 0) {
  Image key(80, 60, 1);
  paint(key, 10 + shift, 20, 25 + shift, 50);
  paint(key, 55, 20, 70, 50);
  return key;
}
Image said(int x, int y, std::uint8_t value) {
  Image map(80, 60, 1, 128);
  *map.at(x, y) = value;
  return map;
}
bool left(const Image& m) { return *m.at(18, 35) == 255; }
bool right(const Image& m) { return *m.at(62, 35) == 255; }

TEST(ChooseIslands, KeepsEverythingWhenNobodySaysAnything) {
  EXPECT_EQ(select_connected_components(two_people(), {}, {}, 5), two_people());
}

TEST(ChooseIslands, KeepsWhatAClickTouches) {
  const Image kept = select_connected_components(two_people(), {}, said(18, 35, 255), 5);
  EXPECT_TRUE(left(kept));
  EXPECT_FALSE(right(kept));
}

TEST(ChooseIslands, DropsWhatABackgroundClickTouches) {
  const Image kept = select_connected_components(two_people(), {}, said(62, 35, 0), 5);
  EXPECT_TRUE(left(kept));
  EXPECT_FALSE(right(kept));
}

TEST(ChooseIslands, FollowsTheSubjectFromTheFrameBefore) {
  Image before(80, 60, 1);
  paint(before, 10, 20, 25, 50);
  const Image kept = select_connected_components(two_people(4), before, {}, 5);
  EXPECT_TRUE(left(kept));
  EXPECT_FALSE(right(kept));
}

TEST(ChooseIslands, TakesInAPartThatComesOffTheSubject) {
  Image before(80, 60, 1), key = two_people();
  paint(before, 10, 20, 25, 50);
  paint(key, 10, 30, 25, 32, 0);  // a belt in the cloth's colour cuts the subject in two
  const Image kept = select_connected_components(key, before, {}, 5);
  EXPECT_EQ(*kept.at(18, 25), 255);
  EXPECT_EQ(*kept.at(18, 45), 255);
}

TEST(ChooseIslands, KeepsTheSoftEdgeAndNoFarHaze) {
  Image key = two_people();
  *key.at(27, 35) = 90;
  *key.at(40, 10) = 90;
  const Image kept = select_connected_components(key, {}, said(18, 35, 255), 5);
  EXPECT_EQ(*kept.at(27, 35), 90);
  EXPECT_EQ(*kept.at(40, 10), 0);
}

}  // namespace
}  // namespace floatstage::matting
