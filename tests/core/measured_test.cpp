#include "core/measured.h"

#include <gtest/gtest.h>

namespace floatstage {
namespace {

TEST(MeasuredFigure, IsAValueAndWhatItRestsOn) {
  const Measured m(0.2126, 40);
  ASSERT_TRUE(m);
  EXPECT_EQ(*m, 0.2126);
  EXPECT_EQ(m.count(), 40);
  EXPECT_EQ(to_words(m, 3, " px"), "0.213 px");
}

TEST(MeasuredFigure, SaysWhyItIsMissingAndNever0) {
  const Measured m = Measured::of(0, 0, "no frame was held out");
  EXPECT_FALSE(m);
  EXPECT_EQ(to_words(m, 3, " px"), "not measured, because no frame was held out");
  EXPECT_EQ(short_words(m, 3, " px"), "not measured");
  EXPECT_THROW((void)*m, CheckFailure) << "nobody reads a number that is not there";
}

TEST(MeasuredFigure, ThatIsMissingIsNeitherLessNorMoreThanAnything) {
  const Measured missing;
  EXPECT_FALSE(missing < 1);
  EXPECT_FALSE(missing > -1);
  EXPECT_TRUE(Measured(0.5, 3) < 1);
}

}  // namespace
}  // namespace floatstage
