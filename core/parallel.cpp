#include "core/parallel.h"

#include <algorithm>
#include <memory>
#include <thread>

#include <pthread.h>

#include "core/thread_pool.h"

namespace floatstage {
namespace {

std::unique_ptr<ThreadPool>& pool() {
  static std::unique_ptr<ThreadPool> instance = std::make_unique<ThreadPool>();
  // A child of fork() has none of these threads: it gets a pool of its own, and never looks at this one
  // again.
  static const bool after_forks [[maybe_unused]] = [] {
    ::pthread_atfork(nullptr, nullptr, [] {
      static_cast<void>(instance.release());  // NOLINT(bugprone-unused-return-value)
      instance = std::make_unique<ThreadPool>();
    });
    return true;
  }();
  return instance;
}

}  // namespace

int default_threads() {
  static const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return cores;
}

void parallel_for(std::size_t count, int threads, IndexBody body) {
  const std::size_t wanted = static_cast<std::size_t>(threads > 0 ? threads : default_threads());
  const std::size_t workers = std::min(wanted, count);
  if (workers <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  pool()->run(count, workers - 1, body);
}

}  // namespace floatstage
