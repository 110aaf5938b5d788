#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace floatstage {

/// A progress bar on standard error: shown only on a terminal, and only once the work has taken two seconds.
/// Thread safe.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::size_t items = 1);

 private:
  void draw(double elapsed);

  const std::string what_;
  const std::size_t total_;
  const bool terminal_;
  const std::chrono::steady_clock::time_point begin_;
  std::mutex mutex_;
  std::size_t done_ = 0;
  double last_drawn_ = 0;
  bool visible_ = false;
};

}  // namespace floatstage
