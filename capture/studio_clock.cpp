#include "capture/studio_clock.h"

#include <ctime>

namespace floatstage::capture {

Timestamp studio_now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return {static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec};
}

}  // namespace floatstage::capture
