#pragma once

#include <chrono>

#include "core/time.h"

namespace floatstage::studio {

/// Now, on the recorder's monotonic clock, which cameras' exposures are stamped with too. Only what runs
/// threads reads it; everything below gets time as a parameter.
inline Timestamp now() {
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(
              std::chrono::steady_clock::now().time_since_epoch())
              .count()};
}

/// Now, on the system's clock, which PTP or NTP keeps the same on all machines of a studio.
inline Timestamp system_now() {
  return {std::chrono::duration_cast<std::chrono::nanoseconds>(
              std::chrono::system_clock::now().time_since_epoch())
              .count()};
}

/// What to add to now() for the studio's common time, which every message carries. now() begins anew when a
/// machine is started, and no two were started together.
inline Nanoseconds to_studio_time() { return system_now() - now(); }

inline double milliseconds_of(Nanoseconds d) { return static_cast<double>(d.count) * 1e-6; }

}  // namespace floatstage::studio
