#include "capture/stream/stream_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage::capture {
namespace {

using testing::Optional;
using Due = StreamGrid::Due;

// 25 a second: 40 ms each.
Timestamp at(std::int64_t ms) { return Timestamp{1'000'000'000} + milliseconds(ms); }

TEST(StreamGrid, BeginsWithTheFirstPicture) {
  StreamGrid grid(25);
  EXPECT_EQ(grid.due(at(0), false), std::nullopt);
  EXPECT_EQ(grid.next(false), std::nullopt);
  EXPECT_THAT(grid.due(at(7), true), Optional(Due{0, false, 0}));
}

TEST(StreamGrid, SendsAPictureAtOnceAndNeverTwoInOneInstant) {
  StreamGrid grid(25);
  grid.due(at(0), true);
  EXPECT_EQ(grid.due(at(20), true), std::nullopt);
  EXPECT_THAT(grid.next(true), Optional(at(40)));
  EXPECT_THAT(grid.due(at(40), true), Optional(Due{1, false, 0}));
  EXPECT_THAT(grid.due(at(99), true), Optional(Due{2, false, 0}));
}

TEST(StreamGrid, RepeatsThePictureForAnInstantThatPassedWithoutOne) {
  StreamGrid grid(25);
  grid.due(at(0), true);
  EXPECT_EQ(grid.due(at(79), false), std::nullopt);
  EXPECT_THAT(grid.next(false), Optional(at(80)));
  EXPECT_THAT(grid.due(at(80), false), Optional(Due{1, true, 0}));
  EXPECT_THAT(grid.due(at(121), true), Optional(Due{2, true, 0})) << "what passed comes before what is new";
  EXPECT_THAT(grid.due(at(121), true), Optional(Due{3, false, 0}));
}

TEST(StreamGrid, LeavesOutWhatPassedWhileNobodyCouldSend) {
  StreamGrid grid(25);
  grid.due(at(0), true);
  EXPECT_THAT(grid.due(at(405), true), Optional(Due{9, true, 8}));
  EXPECT_THAT(grid.due(at(405), true), Optional(Due{10, false, 0}));
}

TEST(StreamGrid, MissesNothingWhileNobodyWatches) {
  StreamGrid grid(25);
  grid.due(at(0), true);
  grid.resume(at(100'000));
  EXPECT_THAT(grid.due(at(100'001), true), Optional(Due{2500, false, 0}));
}

}  // namespace
}  // namespace floatstage::capture
