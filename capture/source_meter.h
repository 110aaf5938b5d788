#pragma once

#include <atomic>

#include "capture/frame_source.h"

namespace floatstage::capture {

/// A source's counters, written by its thread and read by any.
class SourceMeter {
 public:
  void reset() {
    for (auto* counter : {&delivered_, &lost_, &corrupt_, &starved_, &failed_}) counter->store(0);
  }
  void count_lost(std::uint64_t frames) { lost_ += frames; }
  void count_delivered(const Frame& frame) {
    if (frame.info.status == FrameStatus::Corrupt) ++corrupt_;
    ++delivered_;
  }
  void count_starved() { ++starved_; }
  void count_failed() { ++failed_; }
  SourceStats read() const {
    return {delivered_.load(), lost_.load(), corrupt_.load(), starved_.load(), failed_.load()};
  }

 private:
  std::atomic<std::uint64_t> delivered_{0}, lost_{0}, corrupt_{0}, starved_{0}, failed_{0};
};

}  // namespace floatstage::capture
