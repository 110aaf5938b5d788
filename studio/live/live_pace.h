#pragma once

#include <optional>

#include "studio/live/live_quality.h"
#include "studio/live/live_stats.h"

namespace floatstage::studio {

/// How fast a live view is, told once a second, and what follows from that for the quality. Time is a
/// parameter.
class LivePace {
 public:
  LivePace(double target_fps, std::size_t quality) : target_(target_fps), control_(target_fps, quality) {}

  /// A picture was made from `begun` to `done`; with `latency_ms` when it showed a new scene.
  void drew(Timestamp begun, Timestamp done, std::optional<double> latency_ms);
  /// True once a second: the figures below are new, and with `automatic` so may be the quality. `offered`:
  /// instants a second that the cameras have.
  bool judge(Timestamp time, double offered, bool automatic);
  /// The operator's choice; the control goes on from it.
  void choose(std::size_t quality) { control_ = QualityControl(target_, quality); }

  /// When the second began that is judged next; absent before the first picture.
  std::optional<Timestamp> window() const { return window_; }
  double fps() const { return fps_; }                ///< scenes a second
  double latency_ms() const { return latency_ms_; }  ///< the middle one of the last second
  std::size_t quality() const { return control_.level(); }

 private:
  const double target_;
  QualityControl control_;
  std::optional<Timestamp> window_;  // when the present second began
  double busy_ = 0;
  Series latencies_;
  double fps_ = 0, latency_ms_ = 0;
};

}  // namespace floatstage::studio
