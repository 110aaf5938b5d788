#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>

namespace floatstage {

/// Waits until `what` holds; false when it does not within `patience`. For what other threads and processes
/// do: a test that passes does not wait longer than it has to.
inline bool eventually(const std::function<bool()>& what,
                       std::chrono::seconds patience = std::chrono::seconds(20)) {
  std::mutex mutex;
  std::condition_variable nobody;
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!what()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::unique_lock lock(mutex);
    nobody.wait_for(lock, std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace floatstage
