#pragma once

#include <algorithm>

namespace floatstage::apps {

/// Which frame of the take is shown, and how playing moves on. Pure arithmetic: time is given to it.
class TimeLine {
 public:
  /// `rate` is the take's frames a second (0: one instant, never moves).
  TimeLine(int frames, double rate) : frames_(std::max(1, frames)), rate_(rate) {}

  int frames() const { return frames_; }
  int frame() const { return std::min(static_cast<int>(position_), frames_ - 1); }
  double rate() const { return rate_; }
  bool playing = false;
  double speed = 1;  ///< times the recorded rate
  bool loop = true;

  /// The frame with its fraction: what part of its time is over.
  double position() const { return position_; }
  /// Somebody else's clock says where it is.
  void follow(double position) { position_ = std::clamp(position, 0.0, frames_ - 1e-6); }

  void seek(int frame) { position_ = std::clamp(frame, 0, frames_ - 1), ++seeks_; }
  long seeks() const { return seeks_; }  ///< so far
  void step(int frames) { playing = false, seek(frame() + frames); }

  /// `seconds` have passed on the wall.
  void advance(double seconds) {
    if (!playing || rate_ <= 0) return;
    position_ += seconds * rate_ * speed;
    if (position_ < frames_) return;
    if (loop) {
      position_ -= frames_ * static_cast<int>(position_ / frames_);
    } else {
      position_ = frames_ - 1;
      playing = false;
    }
  }

 private:
  const int frames_;
  const double rate_;
  double position_ = 0;
  long seeks_ = 0;
};

}  // namespace floatstage::apps
