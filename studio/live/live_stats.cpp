#include "studio/live/live_stats.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/statistics.h"

namespace floatstage::studio {

double Series::mean() const {
  return values_.empty()
             ? 0
             : std::accumulate(values_.begin(), values_.end(), 0.0) / static_cast<double>(values_.size());
}

double Series::percentile(double share) const {
  return values_.empty() ? 0 : floatstage::percentile(values_, share);
}

double Rate::slowest(double duration, int window) const {
  const int whole = static_cast<int>(std::floor(duration + 1e-9));
  if (whole < window) return mean(duration);
  std::vector<int> count(static_cast<std::size_t>(whole), 0);
  for (double s : seconds_)
    if (s >= 0 && s < whole) ++count[static_cast<std::size_t>(s)];
  int fewest = std::accumulate(count.begin(), count.begin() + window, 0);
  for (int i = 1; i + window <= whole; ++i)
    fewest = std::min(fewest, std::accumulate(count.begin() + i, count.begin() + i + window, 0));
  return static_cast<double>(fewest) / window;
}

}  // namespace floatstage::studio
