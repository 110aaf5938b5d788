#include "matting/keyers/clean_up.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/check.h"
#include "core/random.h"

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

// Blobs, specks, faint strands and holes.
Image clutter(int width, int height, Random& random) {
  Image image(width, height, 1);
  const auto below = [&](int n) { return static_cast<int>(random.uniform(0, n - 1e-9)); };
  for (int i = 0; i < 60; ++i) {
    const int w = 1 + below(i < 4 ? width / 2 : 6), h = 1 + below(i < 4 ? height / 2 : 6);
    const int values[] = {255, 0, 128, 127, 60, 24, 23, 200};
    paint(image, below(width - std::min(w, width - 1)), below(height - std::min(h, height - 1)),
          std::min(w, width), std::min(h, height), values[below(8)]);
  }
  return image;
}

TEST(CleanUp, GivesTheBytesOfTheSlowMethod) {
  Random random(8);
  const CleanupOptions options[] = {{},
                                    kNothing,
                                    {.thin_radius = 3, .smallest_island = 0.03, .smallest_hole = 0.02},
                                    {.close_radius = 2, .smallest_island = 0.02, .smallest_hole = 0.003},
                                    {.close_radius = 4, .thin_radius = 1, .largest_only = true},
                                    {.thin_radius = 30, .smallest_hole = 0.1}};
  for (const auto& [width, height] :
       {std::pair(2, 2), std::pair(64, 30), std::pair(130, 200), std::pair(301, 90)})
    for (int trial = 0; trial < 20; ++trial) {
      const Image image = clutter(width, height, random);
      for (const CleanupOptions& o : options)
        ASSERT_EQ(clean_up(image, o), clean_up_by_labels(image, o))
            << width << ' ' << trial << ' ' << &o - options;
    }
}

}  // namespace
}  // namespace floatstage::matting
