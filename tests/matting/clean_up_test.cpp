#include <gtest/gtest.h>

#include "core/check.h"
#include "matting/keyers/keyer.h"

namespace floatstage::matting {
namespace {

void paint(Image& image, int x0, int y0, int w, int h, int value) {
  for (int y = y0; y < y0 + h; ++y)
    for (int x = x0; x < x0 + w; ++x) *image.at(x, y) = static_cast<std::uint8_t>(value);
}

constexpr CleanupOptions kNothing{.smallest_island = 0, .smallest_hole = 0};

Image person() {
  Image image(120, 90, 1);
  paint(image, 40, 20, 40, 50, 255);
  return image;
}

TEST(CleanUp, LeavesACleanMatteAlone) {
  EXPECT_EQ(clean_up(person(), {}), person());
  EXPECT_EQ(clean_up(person(), kNothing), person());
}

TEST(CleanUp, TakesAwayIslandsUnderTheShareWithTheirSoftEdge) {
  Image image = person();
  paint(image, 5, 5, 7, 7, 60);
  paint(image, 6, 6, 5, 5, 255);  // 25 of 2000 px
  EXPECT_EQ(clean_up(image, {.smallest_island = 0.02}), person());
  EXPECT_EQ(clean_up(image, {.smallest_island = 0.01}), image);
}

TEST(CleanUp, KeepsOneComponentOnRequest) {
  Image image = person();
  paint(image, 90, 20, 25, 50, 255);
  EXPECT_EQ(clean_up(image, {}), image) << "two people";
  EXPECT_EQ(clean_up(image, {.largest_only = true}), person());
}

TEST(CleanUp, FillsHolesUnderTheShareOnly) {
  Image image = person();
  paint(image, 50, 30, 3, 3, 0);
  EXPECT_EQ(clean_up(image, {.smallest_hole = 0.01}), person());
  EXPECT_EQ(clean_up(image, {.smallest_hole = 0.004}), image);
}

TEST(CleanUp, DoesNotFillABayAtThePicturesEdge) {
  Image image = person();
  paint(image, 0, 0, 120, 3, 255);
  paint(image, 10, 0, 2, 2, 0);
  EXPECT_EQ(clean_up(image, {.smallest_island = 0, .smallest_hole = 0.05}), image);
}

TEST(CleanUp, ClosesGapsUpToTwiceTheRadius) {
  Image image = person();
  paint(image, 40, 40, 40, 4, 0);
  EXPECT_EQ(*clean_up(image, {.close_radius = 2}).at(60, 41), 255);
  EXPECT_EQ(*clean_up(image, {.close_radius = 1}).at(60, 41), 0);
}

TEST(CleanUp, CutsAWireThatTouchesTheSubjectButKeepsFingers) {
  Image image = person();
  paint(image, 80, 50, 4, 3, 255);  // a finger
  paint(image, 0, 30, 40, 2, 255);  // a wire from the picture's edge to the back
  const Image clean = clean_up(image, {.thin_radius = 3});
  for (int x = 0; x < 30; ++x) EXPECT_EQ(*clean.at(x, 30), 0) << x;
  for (int x = 80; x < 84; ++x) EXPECT_EQ(*clean.at(x, 51), 255) << x;
  for (int y = 20; y < 70; ++y) EXPECT_EQ(*clean.at(60, y), 255) << y;
}

TEST(CleanUp, KeepsFaintHairThatHangsTogetherWithTheHead) {
  Image image = person();
  paint(image, 60, 5, 1, 15, 90);   // a strand that covers a third of its pixels
  paint(image, 100, 5, 1, 15, 90);  // the same, of nobody
  const Image clean = clean_up(image, {.thin_radius = 3});
  EXPECT_EQ(*clean.at(60, 6), 90);
  EXPECT_EQ(*clean.at(100, 6), 0);
}

TEST(CleanUp, ReturnsNobodyWhenNothingReachesHalfOpacity) {
  EXPECT_EQ(clean_up(Image(20, 20, 1, 127), {}), Image(20, 20, 1, 0));
  EXPECT_EQ(clean_up(Image(20, 20, 1, 0), {}), Image(20, 20, 1, 0));
  EXPECT_TRUE(clean_up({}, {}).empty());
}

TEST(CleanUp, KeepsAnAllSubjectPicture) {
  EXPECT_EQ(clean_up(Image(20, 20, 1, 255), {.close_radius = 3, .thin_radius = 3}), Image(20, 20, 1, 255));
}

TEST(CleanUp, OfColoursIsOurBug) { EXPECT_THROW(clean_up(Image(4, 4, 3), {}), CheckFailure); }

}  // namespace
}  // namespace floatstage::matting
