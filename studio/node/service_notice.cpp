#include "studio/node/service_notice.h"

#include <systemd/sd-daemon.h>

namespace floatstage::studio {

ServiceNotice::ServiceNotice() {
  std::uint64_t microseconds = 0;
  if (sd_watchdog_enabled(0, &microseconds) > 0) period_ = std::chrono::microseconds(microseconds);
}

void ServiceNotice::ready(const std::string& status) const {
  sd_notifyf(0, "READY=1\nSTATUS=%s", status.c_str());
}

void ServiceNotice::alive() {
  const auto now = std::chrono::steady_clock::now();
  if (period_.count() == 0 || now - last_ < period_ / 3) return;
  last_ = now;
  sd_notify(0, "WATCHDOG=1");
}

void ServiceNotice::stopping() const { sd_notify(0, "STOPPING=1"); }

}  // namespace floatstage::studio
