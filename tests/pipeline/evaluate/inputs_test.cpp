#include "pipeline/evaluate/inputs.h"

#include <gmock/gmock.h>

#include "tests/core/rigs.h"
#include "tests/support/camera_grids.h"
#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

using testing::ElementsAre;

TEST(Inputs, AreAllCamerasEachLeftOutInTurn) {
  const Result<Inputs> all = choose_inputs(ring(3), {}, {});
  ASSERT_THAT(all, IsOk());
  EXPECT_THAT(all->input, ElementsAre(true, true, true));
  EXPECT_THAT(all->held, ElementsAre(0, 1, 2));
}

TEST(Inputs, AreComparedWithWhatIsNone) {
  const Result<Inputs> some = choose_inputs(ring(6), {"cam1", "cam3", "cam5"}, {});
  ASSERT_THAT(some, IsOk());
  EXPECT_THAT(some->held, ElementsAre(0, 2, 4));
  EXPECT_THAT(choose_inputs(ring(6), {"every:3"}, {})->held, ElementsAre(1, 2, 4, 5));
  EXPECT_THAT(choose_inputs(ring(6), {"every:1"}, {})->held, ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(choose_inputs(ring(6), {"every:2"}, {"cam4", "cam1"})->held, ElementsAre(4, 1));
}

TEST(Inputs, OfAGridAreComparedWithWhatLiesInTheMiddleOfTheirCells) {
  const Rig wall = camera_wall(5, 5);
  const Result<Inputs> every = choose_inputs(wall, {"every:2"}, {});
  ASSERT_THAT(every, IsOk());
  EXPECT_EQ(std::count(every->input.begin(), every->input.end(), true), 9);
  EXPECT_TRUE(every->input[0] && every->input[2] && !every->input[1] && !every->input[5]);
  EXPECT_THAT(every->held, ElementsAre(6, 8, 16, 18));
  EXPECT_THAT(choose_inputs(wall, {"every:4"}, {})->held, ElementsAre(12));
  EXPECT_THAT(choose_inputs(camera_wall(4, 4), {"every:3"}, {})->held, ElementsAre(5, 6, 9, 10));
}

TEST(Inputs, AreRefusedWithASentence) {
  EXPECT_THAT(choose_inputs(ring(4), {"cam9"}, {}), FailsWith(ErrorCode::NotFound, "'cam9' to draw from"));
  EXPECT_THAT(choose_inputs(ring(4), {}, {"cam9"}), FailsWith(ErrorCode::NotFound, "'cam9' to hold out"));
  for (const char* wrong : {"every:0", "every:", "every:-2", "every:2x"})
    EXPECT_THAT(choose_inputs(ring(4), {wrong}, {}), FailsWith(ErrorCode::InvalidArgument, "every:2"));
  EXPECT_THAT(choose_inputs(ring(4), {"cam1"}, {}), FailsWith(ErrorCode::InvalidArgument, "fewer than two"));
  EXPECT_THAT(choose_inputs(ring(4), {"cam1", "cam2"}, {"cam1"}),
              FailsWith(ErrorCode::InvalidArgument, "fewer than two"));
  EXPECT_THAT(choose_inputs(ring(2), {}, {}), FailsWith(ErrorCode::InvalidArgument, "three cameras"));
}

}  // namespace
}  // namespace floatstage::pipeline
