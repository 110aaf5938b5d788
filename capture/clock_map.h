#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/time.h"

namespace floatstage::capture {

struct ClockMapOptions {
  Nanoseconds window = {20'000'000'000};  ///< how far back the fit looks, in device time
  std::size_t most_samples = 1024;        ///< the oldest go first
  double rate_bound = 300e-6;  ///< |rate - 1| of any clock we believe: crystals stay within 100 ppm
  Nanoseconds step_bound =
      milliseconds(50);  ///< further from the fit, on the early side, is a clock that was set
};

/// How well a device's clock is known.
struct ClockFit {
  double rate = 1;                   ///< studio seconds per device second
  Nanoseconds offset;                ///< studio minus device, at the newest sample
  Nanoseconds delay_p50, delay_p95;  ///< of the transport, beyond the shortest seen in the window
  std::size_t samples = 0;           ///< in the window
  std::uint64_t restarts = 0;        ///< times the device's clock was set or began again
};

/// Maps a camera's own counter to the studio clock by a running fit.
///
/// What is seen is the device's time of an exposure and the studio's time of the picture's arrival. The
/// transport delays every arrival by an unknown amount that is never below some shortest one, so the map is
/// the line *under* all samples of the window that is nearest to them in sum (Moon, Skelly, Towsley:
/// Estimation and removal of clock skew from network delay measurements, INFOCOM 1999): the edge of their
/// lower convex hull over the mean device time. It is exact, has no step size and forgets no earlier minimum
/// within its window. The shortest delay itself cannot be seen from one side: it stays in the map, equal for
/// cameras of one kind on one network. Where the device's clock follows PTP, use its time as it is instead.
///
/// Not thread-safe: it belongs to the thread that reads the camera. Results depend on the samples alone.
class ClockMap {
 public:
  explicit ClockMap(ClockMapOptions options = {}) : options_(options) {}

  /// Takes a sample and returns the exposure's instant on the studio clock, never after `arrival`. A device
  /// time that goes back, or a sample further under the fit than the step bound, is a clock that was set: the
  /// fit begins again there.
  Timestamp observe(Nanoseconds device, Timestamp arrival);

  /// The studio's instant of a device time; nothing before the first sample.
  std::optional<Timestamp> map(Nanoseconds device) const;

  ClockFit fit() const;

 private:
  struct Sample {
    std::int64_t device = 0, arrival = 0;
  };

  void refit();
  std::int64_t at(std::int64_t device) const;

  ClockMapOptions options_;
  std::deque<Sample> samples_;
  // The line: origin_.arrival at origin_.device, and `rate_` from there.
  Sample origin_;
  double rate_ = 1;
  std::uint64_t restarts_ = 0;
};

}  // namespace floatstage::capture
