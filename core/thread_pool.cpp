#include "core/thread_pool.h"

#include <system_error>

namespace floatstage {

/// One call of run(), on its caller's stack.
struct ThreadPool::Loop {
  Loop(std::size_t items, std::size_t helpers, const IndexBody& what)
      : count(items), wanted(helpers), body(what) {}

  void work() {
    for (std::size_t i; (i = next.fetch_add(1)) < count;) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  }

  const std::size_t count;
  std::atomic<std::size_t> next = 0;
  std::mutex failure_mutex;
  std::exception_ptr failure;

  // Under the pool's mutex.
  std::size_t wanted;       // helpers that may still join
  std::size_t helping = 0;  // helpers at work
  bool listed = false;
  Loop* after = nullptr;
  std::condition_variable left;

  const IndexBody& body;
};

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wanted_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

std::size_t ThreadPool::size() const {
  const std::lock_guard lock(mutex_);
  return threads_.size();
}

// Under the mutex.
void ThreadPool::grow(std::size_t helpers) {
  try {
    while (threads_.size() < helpers) threads_.emplace_back([this] { help(); });
  } catch (const std::system_error&) {  // no more threads on this machine: the loop goes on with fewer
  }
}

// Under the mutex.
void ThreadPool::remove(Loop& loop) {
  if (!loop.listed) return;
  loop.listed = false;
  Loop** at = &first_;
  while (*at != &loop) at = &(*at)->after;
  *at = loop.after;
}

void ThreadPool::run(std::size_t count, std::size_t helpers, const IndexBody& body) {
  Loop loop(count, helpers, body);
  {
    const std::lock_guard lock(mutex_);
    grow(helpers);
    Loop** last = &first_;
    while (*last != nullptr) last = &(*last)->after;
    *last = &loop;
    loop.listed = true;
  }
  for (std::size_t i = 0; i < helpers; ++i) wanted_.notify_one();
  loop.work();
  {
    std::unique_lock lock(mutex_);
    remove(loop);  // who has not come yet need not come
    loop.left.wait(lock, [&] { return loop.helping == 0; });
  }
  if (loop.failure) std::rethrow_exception(loop.failure);
}

void ThreadPool::help() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wanted_.wait(lock, [&] { return ending_ || first_ != nullptr; });
    if (first_ == nullptr) return;
    Loop& loop = *first_;
    ++loop.helping;
    if (--loop.wanted == 0) remove(loop);
    lock.unlock();
    loop.work();
    lock.lock();
    // The caller needs the mutex to go on: the loop is there until it is released.
    if (--loop.helping == 0) loop.left.notify_one();
  }
}

}  // namespace floatstage
