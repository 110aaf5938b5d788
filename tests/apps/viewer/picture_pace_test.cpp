#include "apps/viewer/play/picture_pace.h"

#include <gtest/gtest.h>

namespace floatstage::apps {
namespace {

// Pictures whose time goes with their area, in a window that takes `window` seconds besides.
double settle(PicturePace& pace, double full, double window, int pictures = 60) {
  for (int i = 0; i < pictures; ++i) {
    pace.window_took(window);
    pace.drew(full * pace.scale() * pace.scale());
  }
  return full * pace.scale() * pace.scale() + window;
}

TEST(PicturePace, MovesFromTheFirstMoveUntilNothingHasMovedForAWhile) {
  PicturePace pace;
  EXPECT_FALSE(pace.moving(0)) << "the first picture is a full one";
  pace.moved(5);
  EXPECT_TRUE(pace.moving(5.1));
  EXPECT_FALSE(pace.moving(5.2));
}

TEST(PicturePace, DrawsInFullWhereThatIsQuickEnough) {
  PicturePace pace;
  settle(pace, 0.012, 0.01);
  EXPECT_EQ(pace.scale(), 1);
}

TEST(PicturePace, IsAsFineAsThirtyPicturesASecondAllow) {
  PicturePace pace;
  EXPECT_LT(settle(pace, 0.04, 0.01), 1.0 / 30);
  EXPECT_LT(pace.scale(), 1);
  EXPECT_GE(pace.scale(), 9.0 / 16) << "no coarser than it must";
  const double scale = pace.scale();
  for (int i = 0; i < 20; ++i) {
    settle(pace, 0.04, 0.01, 1);
    EXPECT_EQ(pace.scale(), scale) << "and it stays there";
  }
}

TEST(PicturePace, GetsFinerAgainWhenPicturesGetQuicker) {
  PicturePace pace;
  settle(pace, 0.2, 0.01);
  const double coarse = pace.scale();
  EXPECT_EQ(coarse, PicturePace::kCoarsest);
  settle(pace, 0.012, 0.01);
  EXPECT_GT(pace.scale(), coarse + 0.3);
}

TEST(PicturePace, GoesByTheFullPictureBeforeAnythingHasMoved) {
  PicturePace slow, quick;
  slow.stood(0.07);
  EXPECT_LT(slow.scale(), 0.8) << "the first picture of a drag comes in time";
  EXPECT_LE(0.07 * slow.scale() * slow.scale(), 1.0 / 42);
  quick.stood(0.01);
  EXPECT_EQ(quick.scale(), 1);
  settle(slow, 0.015, 0.001);
  slow.stood(0.2);
  EXPECT_EQ(slow.scale(), 1) << "what moving pictures took says more";
}

TEST(PicturePace, LeavesTheFlowOutWhereEvenTheCoarsestTakesTooLong) {
  PicturePace pace;
  settle(pace, 0.08, 0.005);
  EXPECT_FALSE(pace.without_flow());
  settle(pace, 0.4, 0.005);
  EXPECT_TRUE(pace.without_flow());
  pace.stood(0.4);
  EXPECT_TRUE(pace.without_flow());
  pace.stood(0.05);
  EXPECT_FALSE(pace.without_flow()) << "another scene, another machine: it is tried again";
}

TEST(PicturePace, CountsWhatAWindowTakesAtBest) {
  PicturePace waits, quick;
  for (int i = 0; i < 20; ++i) waits.window_took(i % 2 ? 0.016 : 0.004);
  settle(waits, 0.03, 0.004, 5);
  settle(quick, 0.03, 0.004, 5);
  EXPECT_EQ(waits.scale(), quick.scale());
}

TEST(PictureTimes, TellTheMedianAndTheWorst) {
  PictureTimes times;
  EXPECT_EQ(times.percentile(0.5), 0);
  for (const double ms : {10.2, 10.8, 30.0, 9000.0, 10.4}) times.add(ms);
  EXPECT_EQ(times.count(), 5);
  EXPECT_NEAR(times.percentile(0.5), 10.5, 0.5);
  EXPECT_EQ(times.worst(), 9000);
}

}  // namespace
}  // namespace floatstage::apps
