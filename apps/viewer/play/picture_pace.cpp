#include "apps/viewer/play/picture_pace.h"

#include <algorithm>
#include <cmath>

namespace floatstage::apps {
namespace {

// Seconds from picture to picture, while something moves. An input that has just missed one picture waits for
// it and for its own: twice this, and some more as pictures differ, is to stay below 60 ms.
constexpr double kPicture = 1.0 / 42;
constexpr double kLeast = 0.2;  // of it are the drawing's, however slow the window is

}  // namespace

double PicturePace::budget() const { return std::max(kLeast * kPicture, kPicture - window_); }

void PicturePace::stood(double seconds) {
  const double wanted = 16 * std::sqrt(budget() / std::max(seconds, 1e-6));
  if (wanted >= 16 * kCoarsest) without_flow_ = false;
  if (!drew_moving_)
    sixteenths_ = std::clamp(static_cast<int>(std::floor(wanted)), static_cast<int>(16 * kCoarsest), 16);
}

void PicturePace::drew(double seconds) {
  drew_moving_ = true;
  if (sixteenths_ == static_cast<int>(16 * kCoarsest) && seconds > kPicture) without_flow_ = true;
  // Its time goes with its area, or rises more slowly.
  const double wanted = 16 * scale() * std::sqrt(budget() / std::max(seconds, 1e-6));
  if (wanted < sixteenths_) sixteenths_ = static_cast<int>(std::floor(wanted));
  // Up by little steps, and not for what the next picture would take back.
  if (wanted > sixteenths_ + 1.5) ++sixteenths_;
  sixteenths_ = std::clamp(sixteenths_, static_cast<int>(16 * kCoarsest), 16);
}

void PicturePace::window_took(double seconds) {
  // A window that waits for its screen takes longer than it must: what it takes at best counts.
  window_ = window_ == 0 || seconds < window_ ? seconds : 0.95 * window_ + 0.05 * seconds;
}

void PictureTimes::add(double milliseconds) {
  const auto bin = static_cast<std::size_t>(std::clamp(milliseconds, 0.0, bins_.size() - 1.0));
  ++bins_[bin];
  ++count_;
  worst_ = std::max(worst_, milliseconds);
}

double PictureTimes::percentile(double share) const {
  long below = 0;
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    below += bins_[bin];
    if (below > 0 && static_cast<double>(below) >= share * static_cast<double>(count_))
      return static_cast<double>(bin) + 0.5;
  }
  return 0;
}

}  // namespace floatstage::apps
