#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

#include "pipeline/progress.h"

namespace floatstage::apps {

/// A job's progress as a bar on standard error: shown only on a terminal, and only once a part has taken two
/// seconds. Ctrl-C cancels the job. Thread safe.
class ProgressBar final : public pipeline::Progress {
 public:
  ProgressBar();
  ~ProgressBar() override { end(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void begin(const std::string& what, std::size_t total) override;
  void advance(std::size_t items) override;
  void end() override;
  bool cancelled() const override;

 private:
  void draw(double elapsed);

  const bool terminal_;
  std::mutex mutex_;
  std::string what_;
  std::size_t total_ = 0, done_ = 0;
  std::chrono::steady_clock::time_point begin_;
  double last_drawn_ = 0;
  bool visible_ = false;
};

}  // namespace floatstage::apps
