#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace floatstage {

/// What one process has taken from the system, looked at again and again.
class ProcessSamples {
 public:
  ProcessSamples(std::string name, pid_t pid) : name_(std::move(name)), pid_(pid) {}

  void look(double second);

  const std::string& name() const { return name_; }
  /// Medians of what was seen between two shares of the whole time.
  double resident_mb(double from, double to) const { return median(from, to, &Sample::resident_mb); }
  double files(double from, double to) const { return median(from, to, &Sample::files); }
  double threads(double from, double to) const { return median(from, to, &Sample::threads); }

 private:
  struct Sample {
    double second = 0, resident_mb = 0, files = 0, threads = 0;
  };
  double median(double from, double to, double Sample::*what) const;

  std::string name_;
  pid_t pid_;
  std::vector<Sample> samples_;
};

}  // namespace floatstage
