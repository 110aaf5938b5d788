#include "pipeline/film_sight.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage::pipeline {
namespace {

TEST(FilmSight, IsTheMeanAndTheWorstOfTheKnownPictures) {
  FilmSight sight;
  sight.add(10, {.shown = 1000, .seen = 990});
  sight.add(11, {});  // not asked
  sight.add(12, {.shown = 200, .seen = 140});
  sight.add(13, {.shown = 100, .seen = 100});
  EXPECT_EQ(sight.pictures, 3);
  EXPECT_NEAR(sight.unseen, (0.01 + 0.3 + 0) / 3, 1e-12);
  EXPECT_EQ(sight.much, 1);
  EXPECT_NEAR(sight.worst, 0.3, 1e-12);
  EXPECT_EQ(sight.worst_picture, 12);
}

TEST(FilmSight, SaysWhatIsMuchAndNamesThePicture) {
  FilmSight sight;
  EXPECT_EQ(sight.doubt(), std::nullopt);
  sight.add(3, {.shown = 1000, .seen = 960});
  EXPECT_EQ(sight.doubt(), std::nullopt) << "hollows of a hull are not worth a word";
  sight.add(4, {.shown = 1000, .seen = 700});
  ASSERT_TRUE(sight.doubt());
  EXPECT_THAT(*sight.doubt(), testing::HasSubstr("1 of 2 pictures"));
  EXPECT_THAT(*sight.doubt(), testing::HasSubstr("picture 4: 30 %"));
}

TEST(FilmSight, NamesTheFirstPictureWhereAllIsSeen) {
  FilmSight sight;
  sight.add(7, {.shown = 10, .seen = 10});
  sight.add(8, {.shown = 10, .seen = 10});
  EXPECT_EQ(sight.worst_picture, 7);
  EXPECT_EQ(sight.worst, 0);
}

}  // namespace
}  // namespace floatstage::pipeline
