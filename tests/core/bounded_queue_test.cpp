#include "core/bounded_queue.h"

#include <memory>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage {
namespace {

using testing::Eq;
using testing::Optional;

TEST(BoundedQueue, GivesItemsInTheOrderTheyCame) {
  BoundedQueue<int> queue(3, QueuePolicy::Block);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.push(i));
  for (int i = 0; i < 3; ++i) EXPECT_THAT(queue.pop(), Optional(Eq(i)));
}

TEST(BoundedQueue, DropsTheOldestAndCountsItWhenThatIsThePolicy) {
  BoundedQueue<int> queue(2, QueuePolicy::DropOldest);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(queue.push(i));
  EXPECT_THAT(queue.pop(), Optional(Eq(3)));
  EXPECT_THAT(queue.pop(), Optional(Eq(4)));
  const auto counters = queue.counters();
  EXPECT_EQ(counters.pushed, 5u);
  EXPECT_EQ(counters.dropped, 3u);
  EXPECT_EQ(counters.popped, 2u);
  EXPECT_EQ(counters.peak, 2u);
}

TEST(BoundedQueue, GivesUpAfterTheTimeout) {
  BoundedQueue<int> queue(1, QueuePolicy::Block);
  EXPECT_FALSE(queue.pop_for(Nanoseconds{0}));
  queue.push(1);
  EXPECT_THAT(queue.pop_for(Nanoseconds{0}), Optional(Eq(1)));
}

TEST(BoundedQueue, DrainsAfterItIsClosedAndThenGivesNothing) {
  BoundedQueue<int> queue(2, QueuePolicy::Block);
  queue.push(1);
  queue.close();
  EXPECT_FALSE(queue.push(2));
  EXPECT_THAT(queue.pop(), Optional(Eq(1)));
  EXPECT_FALSE(queue.pop());
}

TEST(BoundedQueue, ReleasesAWaitingProducerWhenClosed) {
  BoundedQueue<int> queue(1, QueuePolicy::Block);
  queue.push(1);
  bool accepted = true;
  std::thread producer([&] { accepted = queue.push(2); });
  queue.close();
  producer.join();
  EXPECT_FALSE(accepted);
}

TEST(BoundedQueue, ReleasesAWaitingConsumerWhenClosed) {
  BoundedQueue<int> queue(1, QueuePolicy::Block);
  std::optional<int> got = 1;
  std::thread consumer([&] { got = queue.pop(); });
  queue.close();
  consumer.join();
  EXPECT_FALSE(got);
}

TEST(BoundedQueue, CarriesThingsThatCannotBeCopied) {
  BoundedQueue<std::unique_ptr<int>> queue(1, QueuePolicy::Block);
  queue.push(std::make_unique<int>(7));
  EXPECT_EQ(**queue.pop(), 7);
}

TEST(BoundedQueue, OfNoPlacesIsABug) { EXPECT_THROW(BoundedQueue<int>(0, QueuePolicy::Block), CheckFailure); }

// Four producers and three consumers through `capacity` places; returns how often each item came out.
std::vector<int> crowd(BoundedQueue<int>& queue, int items_each) {
  constexpr int kProducers = 4, kConsumers = 3;
  std::vector<std::vector<int>> got(kConsumers);
  {
    std::vector<std::jthread> consumers;
    for (int c = 0; c < kConsumers; ++c)
      consumers.emplace_back([&, c] {
        while (const std::optional<int> item = queue.pop()) got[c].push_back(*item);
      });
    {
      std::vector<std::jthread> producers;
      for (int p = 0; p < kProducers; ++p)
        producers.emplace_back([&, p] {
          for (int i = 0; i < items_each; ++i) queue.push(p * items_each + i);
        });
    }
    queue.close();
  }
  std::vector<int> times(kProducers * items_each);
  for (const auto& one : got)
    for (int item : one) ++times[item];
  return times;
}

TEST(BoundedQueue, LosesNothingBetweenManyThreadsWhenItBlocks) {
  BoundedQueue<int> queue(2, QueuePolicy::Block);
  EXPECT_THAT(crowd(queue, 500), testing::Each(1));
  EXPECT_EQ(queue.counters().dropped, 0u);
  EXPECT_LE(queue.counters().peak, 2u);
}

TEST(BoundedQueue, AccountsForEveryItemBetweenManyThreadsWhenItDrops) {
  BoundedQueue<int> queue(2, QueuePolicy::DropOldest);
  const std::vector<int> times = crowd(queue, 500);
  EXPECT_THAT(times, testing::Each(testing::Le(1)));
  const auto counters = queue.counters();
  EXPECT_EQ(counters.pushed, 2000u);
  EXPECT_EQ(counters.popped + counters.dropped, 2000u);
  EXPECT_LE(counters.peak, 2u);
}

}  // namespace
}  // namespace floatstage
