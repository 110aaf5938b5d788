#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "core/result.h"

namespace floatstage::render {

/// Whether somebody has given up the picture that is being drawn. The question is put on the thread that
/// began alone (it may look for a window's events); threads that help only hear the answer, which stays.
class Interruption {
 public:
  /// A new picture, on this thread. `ask` may be empty: nobody gives it up.
  void begin(const std::function<bool()>& ask) {
    ask_ = ask;
    thread_ = std::this_thread::get_id();
    given_up_.store(false, std::memory_order_relaxed);
  }
  bool given_up() {
    if (!ask_) return false;
    if (given_up_.load(std::memory_order_relaxed)) return true;
    if (std::this_thread::get_id() != thread_ || !ask_()) return false;
    given_up_.store(true, std::memory_order_relaxed);
    return true;
  }

 private:
  std::function<bool()> ask_;
  std::thread::id thread_;
  std::atomic<bool> given_up_ = false;
};

/// What drawing returns then.
inline Unexpected given_up() { return fail(ErrorCode::Cancelled, "the picture was given up"); }

}  // namespace floatstage::render
