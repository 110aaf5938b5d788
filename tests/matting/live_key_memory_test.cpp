// A program of its own: it replaces operator new to count.

#include <gtest/gtest.h>

#include "matting/keyers/live_key.h"
#include "tests/matting/pictures.h"
#include "tests/support/counted_new.h"

namespace floatstage::matting {
namespace {

TEST(LiveKey, AllocatesNothingOnceItHasSeenItsSubjectAndGotItsMattesBack) {
  const auto keyer = std::move(*make_keyer("chroma:#28783c", {}));
  LiveKey live(*keyer);
  ASSERT_TRUE(live.fast());
  Scene large, small;
  large.radius = 50;
  large.noise = small.noise = 6;
  const Frame frames[] = {make_frame({}, photograph(large)), make_frame({}, photograph(small))};
  Matte held;  // one picture is on its way while the next is keyed
  for (int round = 0; round < 6; ++round) {
    const long before = test::allocations;
    held = *live.key(frames[round % 2]);
    const long during = test::allocations - before;
    if (round == 0) {
      EXPECT_GT(during, 0) << "the counter counts";
    }
    if (round >= 3) {
      EXPECT_EQ(during, 0) << "round " << round;
    }
  }
}

}  // namespace
}  // namespace floatstage::matting
