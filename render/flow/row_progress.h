#pragma once

#include <atomic>

namespace floatstage::render {

/// How many rows of a plane are done, told by the thread that makes them to one that goes on with them.
class RowProgress {
 public:
  void begin() { rows_.store(0, std::memory_order_relaxed); }
  /// The rows before `rows` are done; all that was written to them is seen by whoever waited for them.
  void tell(int rows) {
    if (rows <= rows_.load(std::memory_order_relaxed)) return;
    rows_.store(rows, std::memory_order_release);
    rows_.notify_all();
  }
  void await(int rows) const {
    for (int done; (done = rows_.load(std::memory_order_acquire)) < rows;)
      rows_.wait(done, std::memory_order_acquire);
  }

 private:
  std::atomic<int> rows_ = 0;
};

}  // namespace floatstage::render
