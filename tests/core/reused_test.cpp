#include "core/reused.h"

#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace floatstage {
namespace {

TEST(Reused, HandsOutAgainWhatNobodyHasAnyMore) {
  Reused<std::string> pool;
  const std::string* first = nullptr;
  {
    const std::shared_ptr<std::string> taken = pool.take();
    EXPECT_TRUE(taken->empty());
    *taken = "what its last user left";
    first = taken.get();
  }
  const std::shared_ptr<std::string> again = pool.take();
  EXPECT_EQ(again.get(), first);
  EXPECT_EQ(*again, "what its last user left");
}

TEST(Reused, NeverHandsOutWhatSomebodyHas) {
  Reused<int> pool;
  const std::shared_ptr<const int> held = pool.take();
  const std::shared_ptr<const int> copy = held;
  EXPECT_NE(pool.take(), held);
  const std::shared_ptr<const int> other = pool.take(), third = pool.take();
  EXPECT_NE(other, held);
  EXPECT_NE(third, held);
  EXPECT_NE(third, other);
}

TEST(Reused, LeavesWhatWasTakenToItsHolder) {
  std::shared_ptr<std::string> held;
  {
    Reused<std::string> pool;
    held = pool.take();
    *held = "still there";
  }
  EXPECT_EQ(*held, "still there");
}

// Of worth under the thread sanitizer: who takes an object sees all that its last user did with it.
TEST(Reused, ComesBackFromOtherThreads) {
  constexpr int kRounds = 200;
  Reused<int> pool;
  std::vector<std::thread> threads;
  for (int i = 0; i < kRounds; ++i) {
    std::shared_ptr<int> taken = pool.take();
    ++*taken;
    threads.emplace_back([handed = std::move(taken)]() mutable {
      ++*handed;
      handed.reset();
    });
  }
  for (std::thread& thread : threads) thread.join();
  int sum = 0;
  std::vector<std::shared_ptr<int>> all;
  do sum += *all.emplace_back(pool.take());
  while (*all.back() != 0);  // a new one: those before are all there are
  EXPECT_EQ(sum, 2 * kRounds);
}

}  // namespace
}  // namespace floatstage
