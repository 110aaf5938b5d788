#pragma once

#include <vector>

#include "capture/take.h"

namespace floatstage::apps {

/// When a take's frames were taken, s after the first one: each by the camera that was first. Where its clock
/// does not go forward (pictures without times) nothing is known.
class FrameClock {
 public:
  FrameClock() = default;
  explicit FrameClock(const capture::TakeReader& take);
  /// Of times in order; for tests.
  explicit FrameClock(std::vector<double> times, Timestamp begin = {})
      : times_(std::move(times)), begin_(begin) {}

  bool known() const { return times_.size() > 1; }
  Timestamp begin() const { return begin_; }
  /// Until the last frame was over.
  double length() const;
  double seconds_at(double position) const;  ///< of a frame's number with its fraction
  double position_at(double seconds) const;  ///< 0 … frames

 private:
  std::vector<double> times_;
  Timestamp begin_;
};

}  // namespace floatstage::apps
