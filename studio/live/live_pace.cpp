#include "studio/live/live_pace.h"

namespace floatstage::studio {

void LivePace::drew(Timestamp begun, Timestamp done, std::optional<double> latency_ms) {
  if (!window_) window_ = begun;
  busy_ += seconds(done - begun);
  if (latency_ms) latencies_.add(*latency_ms);
}

bool LivePace::judge(Timestamp time, double offered, bool automatic) {
  if (!window_) return false;
  const double passed = seconds(time - *window_);
  if (passed < 1) return false;
  fps_ = static_cast<double>(latencies_.count()) / passed;
  latency_ms_ = latencies_.percentile(0.5);
  if (automatic) control_.judge(time, fps_, offered, busy_ / passed);
  window_ = time;
  busy_ = 0;
  latencies_ = {};
  return true;
}

}  // namespace floatstage::studio
