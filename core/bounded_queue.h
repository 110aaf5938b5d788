#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "core/check.h"
#include "core/time.h"

namespace floatstage {

/// What a full queue does with one more item.
enum class QueuePolicy {
  Block,       ///< push() waits: nothing is lost silently (the recorder)
  DropOldest,  ///< the oldest item goes: the newest is what matters (the live view)
};

/// A first-in first-out queue between threads, with a stated bound and counters. Any number of producers and
/// consumers. After close(), push() is refused and pop() drains what is left, then returns nothing.
template <class T>
class BoundedQueue {
 public:
  struct Counters {
    std::uint64_t pushed = 0, popped = 0, dropped = 0;
    std::size_t peak = 0;  ///< most items ever held
  };

  BoundedQueue(std::size_t capacity, QueuePolicy policy) : capacity_(capacity), policy_(policy) {
    FLOATSTAGE_CHECK(capacity > 0, "a queue of no places");
  }

  /// False when the queue is closed; the item is then gone.
  bool push(T item) {
    std::unique_lock lock(mutex_);
    if (policy_ == QueuePolicy::Block) {
      not_full_.wait(lock, [&] { return closed_ || items_.size() < capacity_; });
    } else if (items_.size() == capacity_ && !closed_) {
      items_.pop_front();
      ++counters_.dropped;
    }
    if (closed_) return false;
    items_.push_back(std::move(item));
    ++counters_.pushed;
    counters_.peak = std::max(counters_.peak, items_.size());
    lock.unlock();
    not_empty_.notify_one();
    return true;
  }

  /// Waits for an item; nothing when the queue is closed and drained.
  std::optional<T> pop() {
    std::unique_lock lock(mutex_);
    not_empty_.wait(lock, [&] { return closed_ || !items_.empty(); });
    return take_front(lock);
  }

  /// As pop(), but gives up after `timeout`.
  std::optional<T> pop_for(Nanoseconds timeout) {
    std::unique_lock lock(mutex_);
    not_empty_.wait_for(lock, std::chrono::nanoseconds(timeout.count),
                        [&] { return closed_ || !items_.empty(); });
    return take_front(lock);
  }

  void close() {
    {
      std::lock_guard lock(mutex_);
      closed_ = true;
    }
    not_empty_.notify_all();
    not_full_.notify_all();
  }

  Counters counters() const {
    std::lock_guard lock(mutex_);
    return counters_;
  }

 private:
  std::optional<T> take_front(std::unique_lock<std::mutex>& lock) {
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    ++counters_.popped;
    lock.unlock();
    not_full_.notify_one();
    return item;
  }

  const std::size_t capacity_;
  const QueuePolicy policy_;
  mutable std::mutex mutex_;
  std::condition_variable not_empty_, not_full_;
  std::deque<T> items_;
  Counters counters_;
  bool closed_ = false;
};

}  // namespace floatstage
