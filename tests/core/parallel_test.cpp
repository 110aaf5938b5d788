#include "core/parallel.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/thread_pool.h"

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

TEST_P(ParallelFor, LetsItemsWaitForThoseBefore) {
  std::vector<std::atomic<bool>> done(200);
  parallel_for(done.size(), GetParam(), [&](std::size_t i) {
    if (i > 0) done[i - 1].wait(false);
    done[i] = true;
    done[i].notify_all();
  });
  for (const std::atomic<bool>& is : done) EXPECT_TRUE(is);
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

// Notes the threads that items ran on. Items hold on until `others` threads are there too, or it takes long.
std::set<std::thread::id> threads_of(ThreadPool& pool, std::size_t helpers) {
  std::mutex mutex;
  std::condition_variable came;
  std::set<std::thread::id> seen;
  pool.run(helpers + 1, helpers, [&](std::size_t) {
    std::unique_lock lock(mutex);
    seen.insert(std::this_thread::get_id());
    came.notify_all();
    came.wait_for(lock, std::chrono::seconds(20), [&] { return seen.size() == helpers + 1; });
  });
  return seen;
}

TEST(ThreadPool, KeepsItsThreads) {
  ThreadPool pool;
  const std::set<std::thread::id> first = threads_of(pool, 3);
  EXPECT_THAT(first, testing::SizeIs(4));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(threads_of(pool, 3), first);
  EXPECT_EQ(pool.size(), 3u);
  EXPECT_THAT(first, testing::IsSupersetOf(threads_of(pool, 1))) << "fewer are some of them";
  EXPECT_EQ(pool.size(), 3u);
}

TEST(ThreadPool, WorksInsideOfItsOwnLoopsAndFromManyThreads) {
  ThreadPool pool;
  std::atomic<int> done = 0;
  const auto nested = [&] {
    pool.run(5, 2, [&](std::size_t) { pool.run(7, 2, [&](std::size_t) { ++done; }); });
  };
  {
    std::vector<std::jthread> callers;
    for (int i = 0; i < 4; ++i)
      callers.emplace_back([&] {
        for (int k = 0; k < 50; ++k) nested();
      });
  }
  EXPECT_EQ(done, 4 * 50 * 5 * 7);
  EXPECT_EQ(pool.size(), 2u) << "as many as one call asked for, however many called";
}

TEST(ThreadPool, WaitsForNobodyWhoHasNotBegun) {
  ThreadPool pool;
  std::atomic<bool> release = false, begun = false;
  std::jthread busy([&] {
    pool.run(2, 1, [&](std::size_t) {
      begun = true;
      while (!release) std::this_thread::yield();
    });
  });
  while (!begun) std::this_thread::yield();
  int done = 0;
  std::mutex mutex;
  pool.run(10, 1, [&](std::size_t) {
    const std::lock_guard lock(mutex);
    ++done;
  });
  EXPECT_EQ(done, 10) << "its only thread may still be in the other loop";
  release = true;
}

TEST(ThreadPool, GoesOnAfterAFailure) {
  ThreadPool pool;
  for (int i = 0; i < 20; ++i)
    EXPECT_THROW(pool.run(9, 2, [](std::size_t) { throw std::runtime_error("no"); }), std::runtime_error);
  std::atomic<int> done = 0;
  pool.run(9, 2, [&](std::size_t) { ++done; });
  EXPECT_EQ(done, 9);
}

TEST(DefaultThreads, IsAtLeastOne) { EXPECT_GE(default_threads(), 1); }

}  // namespace
}  // namespace floatstage
