#pragma once

#include <array>
#include <cstddef>

namespace floatstage::apps {

/// How finely pictures are drawn while something moves, so that the window follows the hand where pictures
/// are drawn on the CPU: at rest in full, and while the camera moves or the take plays as finely as one
/// forty-second of a second allows, by what the last pictures took. Seconds are of any clock. Without a
/// window.
class PicturePace {
 public:
  /// Something has moved.
  void moved(double now) { last_move_ = now, ever_moved_ = true; }
  /// A full picture was drawn, at rest, in so many seconds: where nothing has moved yet, what the first
  /// moving picture goes by.
  void stood(double seconds);
  bool moving(double now) const { return ever_moved_ && now - last_move_ < kRest; }
  /// Pixels drawn per pixel shown, along a line: kCoarsest … 1.
  double scale() const { return static_cast<double>(sixteenths_) / 16; }
  /// Even the coarsest picture takes too long with flow: it is left out while something moves.
  bool without_flow() const { return without_flow_; }
  /// A picture was drawn with scale() in so many seconds, without flow where without_flow() said so.
  void drew(double seconds);
  /// The window's frame took so long without the picture.
  void window_took(double seconds);

  static constexpr double kRest = 0.12;     ///< seconds without a move after which the camera is at rest
  static constexpr double kCoarsest = 0.5;  ///< below this the picture says little of what rest will show

 private:
  double last_move_ = 0;
  bool ever_moved_ = false;
  double budget() const;

  int sixteenths_ = 16;
  bool drew_moving_ = false, without_flow_ = false;
  double window_ = 0;
};

/// How long pictures took, for reports. Counts in bins of a millisecond: it does not grow.
class PictureTimes {
 public:
  void add(double milliseconds);
  long count() const { return count_; }
  /// This share of the pictures (0…1) took less, to a millisecond; 0 without pictures.
  double percentile(double share) const;
  double worst() const { return worst_; }

 private:
  std::array<long, 4096> bins_{};
  long count_ = 0;
  double worst_ = 0;
};

}  // namespace floatstage::apps
