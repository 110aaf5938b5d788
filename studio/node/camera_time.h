#pragma once

#include <mutex>
#include <optional>

#include "core/time.h"

namespace floatstage::studio {

/// What a node's cameras call the time, for a program that waits by the monotonic clock and tells others by
/// the systems' time. Cameras without PTP are stamped on the monotonic clock already. With PTP they have the
/// network's time, decades away from it: their exposures are brought to the monotonic clock by the shortest
/// time that a picture ever took to arrive (followed slowly, so that drifting clocks stay together), and told
/// in the network's own seconds, whatever the system's number of leap seconds is. Safe from any thread.
class CameraTime {
 public:
  /// An exposure on the monotonic clock; `produced` is when its picture came, on that clock.
  Timestamp to_monotonic(Timestamp exposed, Timestamp produced);
  /// When a picture was produced, on the monotonic clock, which is where latency begins: at its exposure and
  /// never after `arrived`. Whoever fetches pictures may have had to wait, for a disk or for the processor,
  /// and what it then stamps itself would hide that.
  Timestamp produced(Timestamp exposed, Timestamp arrived);
  /// What to add to times of to_monotonic() for the systems' time. `system` and `monotonic` are now.
  Nanoseconds to_system(Timestamp system, Timestamp monotonic) const;

 private:
  mutable std::mutex mutex_;
  std::optional<Nanoseconds>
      apart_;  // from the cameras' clock to the monotonic one; nothing while it is the same
};

}  // namespace floatstage::studio
