#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/parallel.h"

namespace floatstage {

/// The threads that help parallel_for(), kept from call to call. A call puts its loop on a list, works on it
/// itself, and threads without work join it; so a call never waits for a thread that has not begun, calls
/// from several threads and calls inside of a loop's body share the same threads, and none can block another.
/// Internal to parallel.cpp; its own header so that tests can make pools of their own.
class ThreadPool {
 public:
  ThreadPool() = default;
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// body(i) for every i in [0, count), on this thread and up to `helpers` others. Threads are started when
  /// more helpers are asked for than ever before; where the system refuses them, fewer help. After that
  /// nothing is allocated. Any thread, at any time.
  void run(std::size_t count, std::size_t helpers, const IndexBody& body);

  std::size_t size() const;  ///< threads that are there

 private:
  struct Loop;
  void help();
  void grow(std::size_t helpers);
  void remove(Loop& loop);

  mutable std::mutex mutex_;
  std::condition_variable wanted_;
  Loop* first_ = nullptr;  // those that want help, in the order in which they came
  bool ending_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace floatstage
