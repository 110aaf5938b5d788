#include "studio/node/foreground_tile.h"

#include <gtest/gtest.h>

namespace floatstage::studio {
namespace {

Matte small_matte(int width, int height, const std::vector<PixelBox>& subject) {
  Image alpha(width, height, 1);
  for (const PixelBox& box : subject)
    for (int y = box.y; y < box.y + box.height; ++y)
      for (int x = box.x; x < box.x + box.width; ++x) *alpha.at(x, y) = 255;
  return make_matte({}, alpha);
}

Image enlarged(const Matte& small, int factor, const PixelBox& box) {
  Image large;
  MatteEnlarger().enlarge(small, factor, box, large);
  return large;
}

bool contains(const PixelBox& box, int x, int y) {
  return x >= box.x && y >= box.y && x < box.x + box.width && y < box.y + box.height;
}

TEST(SubjectBox, HoldsTheSubjectWithABorderAndEndsAtThePicture) {
  const PixelBox box = subject_box(small_matte(40, 30, {{10, 12, 5, 6}}), 2, 80, 60);
  EXPECT_TRUE(contains(box, 20 - 4, 24 - 4));
  EXPECT_TRUE(contains(box, 29 + 4, 35 + 4));
  EXPECT_LT(box.width, 26);
  const PixelBox corner = subject_box(small_matte(40, 30, {{0, 0, 2, 2}, {38, 28, 2, 2}}), 2, 79, 59);
  EXPECT_EQ(corner, (PixelBox{0, 0, 79, 59}));
}

TEST(SubjectBox, IsEmptyWithoutASubject) {
  EXPECT_TRUE(subject_box(small_matte(40, 30, {}), 2, 80, 60).empty());
}

TEST(SubjectBox, SeesFaintHairToo) {
  Image alpha(40, 30, 1);
  *alpha.at(3, 4) = 1;
  EXPECT_FALSE(subject_box(make_matte({}, alpha), 2, 80, 60).empty());
}

TEST(Enlarged, IsTheMatteItselfAtFullSize) {
  const Matte matte = small_matte(12, 9, {{3, 2, 4, 5}});
  const Image same = enlarged(matte, 1, {2, 1, 8, 7});
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 8; ++x) EXPECT_EQ(*same.at(x, y), matte.row(y + 1)[x + 2]);
}

// A straight edge in the small matte stays where it is: no shift by half a pixel.
TEST(Enlarged, KeepsEdgesWhereTheyAre) {
  for (int factor : {2, 3, 4}) {
    const Matte matte = small_matte(20, 10, {{5, 0, 15, 10}});
    const Image large = enlarged(matte, factor, {0, 0, 20 * factor, 10 * factor});
    int first = 0;
    while (*large.at(first, 5) < 128) ++first;
    EXPECT_EQ(first, 5 * factor) << "enlarged by " << factor;
    const int inside = *large.at(5 * factor, 5), outside = *large.at(5 * factor - 1, 5);
    EXPECT_NEAR(inside + outside, 255, 1) << "the edge is symmetric";
  }
}

TEST(Enlarged, HoldsTheBorderBeyondTheLastPixel) {
  const Image large = enlarged(small_matte(4, 4, {{0, 0, 4, 4}}), 4, {0, 0, 15, 15});
  for (std::uint8_t v : large.pixels) EXPECT_EQ(v, 255);
}

TEST(Enlarged, DoesNotHangOnWhatWasEnlargedBefore) {
  const Matte matte = small_matte(20, 10, {{5, 2, 9, 6}}), other = small_matte(31, 17, {{0, 0, 31, 17}});
  MatteEnlarger used;
  Image out;
  used.enlarge(other, 4, {0, 0, 124, 68}, out);
  for (const PixelBox& box : {PixelBox{4, 2, 30, 15}, PixelBox{0, 0, 40, 20}}) {
    used.enlarge(matte, 2, box, out);
    EXPECT_EQ(out, enlarged(matte, 2, box));
  }
}

}  // namespace
}  // namespace floatstage::studio
