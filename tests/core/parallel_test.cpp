#include "core/parallel.h"

#include <atomic>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage {
namespace {

class ParallelFor : public testing::TestWithParam<int> {};

TEST_P(ParallelFor, DoesEveryItemOnce) {
  std::vector<int> done(1000);
  parallel_for(done.size(), GetParam(), [&](std::size_t i) { ++done[i]; });
  EXPECT_THAT(done, testing::Each(1));
}

TEST_P(ParallelFor, DoesNothingOfNothing) {
  parallel_for(0, GetParam(), [](std::size_t) { FAIL(); });
}

TEST_P(ParallelFor, RethrowsWhatABodyThrew) {
  std::atomic<int> begun = 0;
  EXPECT_THROW(parallel_for(100'000, GetParam(),
                            [&](std::size_t i) {
                              ++begun;
                              if (i == 3) throw std::runtime_error("three");
                            }),
               std::runtime_error);
  EXPECT_GE(begun, 4);
}

INSTANTIATE_TEST_SUITE_P(Threads, ParallelFor, testing::Values(0, 1, 2, 7));

TEST(ParallelForOneThread, GoesInOrderAndStopsAtTheFirstFailure) {
  std::vector<std::size_t> order;
  EXPECT_THROW(parallel_for(9, 1,
                            [&](std::size_t i) {
                              order.push_back(i);
                              if (i == 4) throw std::runtime_error("four");
                            }),
               std::runtime_error);
  EXPECT_THAT(order, testing::ElementsAre(0, 1, 2, 3, 4));
}

TEST(DefaultThreads, IsAtLeastOne) { EXPECT_GE(default_threads(), 1); }

}  // namespace
}  // namespace floatstage
