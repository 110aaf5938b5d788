#include "tests/soak/process_samples.h"

#include <filesystem>
#include <fstream>

#include "core/statistics.h"
#include "core/text.h"

namespace floatstage {

void ProcessSamples::look(double second) {
  Sample sample;
  sample.second = second;
  std::ifstream status(text("/proc/", pid_, "/status"));
  for (std::string word; status >> word;) {
    if (word == "VmRSS:") status >> sample.resident_mb;  // kB
    if (word == "Threads:") status >> sample.threads;
  }
  sample.resident_mb /= 1000;
  std::error_code gone;
  for (const auto& file : std::filesystem::directory_iterator(text("/proc/", pid_, "/fd"), gone)) {
    static_cast<void>(file);
    ++sample.files;
  }
  samples_.push_back(sample);
}

double ProcessSamples::median(double from, double to, double Sample::*what) const {
  std::vector<double> seen;
  const double whole = samples_.empty() ? 0 : samples_.back().second;
  for (const Sample& sample : samples_)
    if (sample.second >= from * whole && sample.second <= to * whole) seen.push_back(sample.*what);
  return seen.empty() ? 0 : percentile(seen, 0.5);
}

}  // namespace floatstage
