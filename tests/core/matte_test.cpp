#include "core/matte.h"

#include <gtest/gtest.h>

#include "core/check.h"

namespace floatstage {
namespace {

Matte row_of(std::vector<std::uint8_t> alpha) {
  Image image(static_cast<int>(alpha.size()), 1, 1);
  image.pixels = std::move(alpha);
  return make_matte({}, image);
}

TEST(Matte, OwnsACopyOfItsImage) {
  Image image(3, 2, 1);
  image.at(2, 1)[0] = 200;
  const Matte matte = make_matte({}, image);
  const Image before = image;
  image.pixels.assign(6, 0);
  EXPECT_EQ(to_image(matte), before);
  EXPECT_EQ(matte.row(1)[2], 200);
}

TEST(Matte, ReadsPaddedRows) {
  auto alpha = std::shared_ptr<std::uint8_t[]>(new std::uint8_t[6]{1, 2, 99, 3, 4, 99});
  const Matte matte{{}, 2, 2, 3, alpha};
  EXPECT_EQ(to_image(matte).pixels, (std::vector<std::uint8_t>{1, 2, 3, 4}));
}

TEST(Matte, ThatDoesNotKnowIsEmpty) {
  EXPECT_TRUE(Matte{}.empty());
  EXPECT_TRUE(to_image(Matte{}).empty());
  EXPECT_EQ(coverage(Matte{}), 0);
}

TEST(Matte, HasOneChannel) { EXPECT_THROW(make_matte({}, Image(2, 2, 3)), CheckFailure); }

TEST(Coverage, CountsPixelsThatAreHalfSubjectOrMore) {
  EXPECT_DOUBLE_EQ(coverage(row_of({0, 127, 128, 255})), 0.5);
}

TEST(Iou, IsTheCommonShareOfBothSubjects) {
  EXPECT_DOUBLE_EQ(iou(row_of({255, 255, 0, 0}), row_of({0, 255, 255, 0})), 1.0 / 3);
  EXPECT_DOUBLE_EQ(iou(row_of({255, 0}), row_of({128, 127})), 1);
  EXPECT_DOUBLE_EQ(iou(row_of({255, 0}), row_of({0, 255})), 0);
}

TEST(Iou, OfTwoMattesWithoutSubjectIsOne) { EXPECT_DOUBLE_EQ(iou(row_of({0, 0}), row_of({10, 0})), 1); }

TEST(Iou, OfDifferentSizesIsABug) { EXPECT_THROW(iou(row_of({0}), row_of({0, 0})), CheckFailure); }

}  // namespace
}  // namespace floatstage
