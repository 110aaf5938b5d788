#pragma once

#include <cstddef>
#include <string>

#include "core/result.h"

namespace floatstage::pipeline {

/// How a job on a take is watched, and stopped. A job's options carry one, which outlives the job; null means
/// that nobody watches and that nothing stops it. All members are called from any thread.
class Progress {
 public:
  virtual ~Progress() = default;
  /// A part of the job begins that has so many items, in the words of a progress bar: "mattes".
  virtual void begin(const std::string& what, std::size_t total) = 0;
  virtual void advance(std::size_t items) = 0;
  virtual void end() = 0;
  /// Whether the job is to end between two items.
  virtual bool cancelled() const = 0;
};

inline bool is_cancelled(const Progress* progress) { return progress != nullptr && progress->cancelled(); }

/// Cancelled, in the words users see.
Unexpected cancelled();
/// The same of work that leaves nothing behind.
Unexpected cancelled_unwritten();

/// One part of a job, from its first item to its last. `progress` may be null.
class ProgressPart {
 public:
  ProgressPart(Progress* progress, const std::string& what, std::size_t total) : progress_(progress) {
    if (progress_) progress_->begin(what, total);
  }
  ~ProgressPart() {
    if (progress_) progress_->end();
  }
  ProgressPart(const ProgressPart&) = delete;
  ProgressPart& operator=(const ProgressPart&) = delete;

  void advance(std::size_t items = 1) {
    if (progress_) progress_->advance(items);
  }

 private:
  Progress* const progress_;
};

}  // namespace floatstage::pipeline
