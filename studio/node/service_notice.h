#pragma once

#include <chrono>
#include <string>

namespace floatstage::studio {

/// Tells systemd how the daemon is (sd_notify); says nothing where it was not started as a service.
class ServiceNotice {
 public:
  ServiceNotice();
  /// All cameras stream.
  void ready(const std::string& status) const;
  /// To be called often while the daemon is well; feeds the watchdog as often as it asks.
  void alive();
  void stopping() const;

 private:
  std::chrono::microseconds period_{0};  // of the watchdog; 0: there is none
  std::chrono::steady_clock::time_point last_;
};

}  // namespace floatstage::studio
