#pragma once

#include <map>
#include <string>
#include <vector>

namespace floatstage::studio {

/// Measurements of one kind.
class Series {
 public:
  void add(double value) { values_.push_back(value); }
  std::size_t count() const { return values_.size(); }
  double mean() const;
  /// As core/statistics.h has it; 0 without any.
  double percentile(double share) const;
  double largest() const { return percentile(1); }

 private:
  std::vector<double> values_;
};

/// How many pictures came in each second, by the times of their coming.
class Rate {
 public:
  void add(double second) { seconds_.push_back(second); }
  std::size_t count() const { return seconds_.size(); }
  double mean(double duration) const {
    return duration > 0 ? static_cast<double>(seconds_.size()) / duration : 0;
  }
  /// Of all whole windows of that many seconds that begin on a second: the fewest a second.
  double slowest(double duration, int window) const;

 private:
  std::vector<double> seconds_;
};

}  // namespace floatstage::studio
