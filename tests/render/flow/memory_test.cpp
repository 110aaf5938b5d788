// A program of its own: it replaces operator new to count.

#include "render/flow/variational_flow.h"
#include "tests/render/flow/pictures.h"
#include "tests/support/counted_new.h"
#include "tests/support/matchers.h"

namespace floatstage::render::test {
namespace {

TEST(VariationalFlow, AllocatesNothingOnceItHasSeenPicturesOfASize) {
  FlowOptions options;
  options.finest_scale = 1;
  auto estimator = std::move(*make_variational_flow(options));
  std::vector<FlowField> fields(2);
  const FlowPair pairs[] = {{0, 1}, {1, 0}};
  bool first_time = true;
  for (const auto& [width, height] : {std::pair(160, 120), std::pair(130, 111), std::pair(160, 120)}) {
    const auto a = wavy(width, height, 0, 0), b = wavy(width, height, 2, 1), state = disc(width, height);
    const FlowImage images[] = {{width, height, a.data(), state.data()},
                                {width, height, b.data(), state.data()}};
    const long before = floatstage::test::allocations;
    const Result<void> ok = estimator->estimate(images, pairs, {}, 1, fields);
    const long during = floatstage::test::allocations - before;
    ASSERT_THAT(ok, IsOk());
    if (first_time) {
      EXPECT_GT(during, 0) << "the counter counts";
    } else {
      EXPECT_EQ(during, 0) << width << "x" << height;
    }
    first_time = false;
  }
}

}  // namespace
}  // namespace floatstage::render::test
