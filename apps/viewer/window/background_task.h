#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <mutex>
#include <string>

namespace floatstage::apps {

/// One piece of long work beside the window: at most one at a time, which can be watched and asked to stop.
class BackgroundTask {
 public:
  struct Progress {
    std::string what;
    int done = 0, all = 0;
  };

  ~BackgroundTask() { stop(); }  // the future's destructor waits for the thread

  /// Only when nothing is running. `work` asks stopped() between two items.
  void start(std::function<void()> work) {
    stop_ = false;
    report({}, 0, 0);
    future_ = std::async(std::launch::async, std::move(work));
  }
  bool running() const { return future_.valid(); }
  /// True once after the work has ended; from then on another may start.
  bool finished() {
    if (!running() || future_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    future_.get();
    return true;
  }
  void wait() const {
    if (running()) future_.wait();
  }

  void stop() { stop_ = true; }
  bool stopped() const { return stop_; }

  /// From any thread.
  void report(const std::string& what, int done, int all) {
    std::lock_guard lock(mutex_);
    progress_ = {what, done, all};
  }
  Progress progress() const {
    std::lock_guard lock(mutex_);
    return progress_;
  }

 private:
  std::atomic<bool> stop_ = false;
  mutable std::mutex mutex_;
  Progress progress_;
  std::future<void> future_;
};

}  // namespace floatstage::apps
