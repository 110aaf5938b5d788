#include "apps/viewer/play/frame_clock.h"

#include <algorithm>
#include <optional>

namespace floatstage::apps {

FrameClock::FrameClock(const capture::TakeReader& take) {
  std::vector<Timestamp> all;
  for (int f = 0; f < take.frame_count(); ++f) {
    std::optional<Timestamp> first;
    for (int c = 0; c < static_cast<int>(take.rig().cameras.size()); ++c)
      if (const std::vector<FrameRow>& rows = take.rows(c); static_cast<std::size_t>(f) < rows.size()) {
        const Timestamp own = rows[static_cast<std::size_t>(f)].info.exposure_start;
        first = first ? std::min(*first, own) : own;
      }
    if (!first || (!all.empty() && *first <= all.back())) return;
    all.push_back(*first);
  }
  if (all.empty()) return;
  begin_ = all.front();
  for (const Timestamp t : all) times_.push_back(seconds(t - begin_));
}

double FrameClock::length() const {
  if (!known()) return 0;
  return times_.back() + times_.back() / static_cast<double>(times_.size() - 1);
}

double FrameClock::seconds_at(double position) const {
  if (!known()) return 0;
  const double last = static_cast<double>(times_.size());
  const double at = std::clamp(position, 0.0, last);
  const auto frame = std::min(static_cast<std::size_t>(at), times_.size() - 1);
  const double next = frame + 1 < times_.size() ? times_[frame + 1] : length();
  return times_[frame] + (at - static_cast<double>(frame)) * (next - times_[frame]);
}

double FrameClock::position_at(double seconds) const {
  if (!known()) return 0;
  const auto after = std::upper_bound(times_.begin(), times_.end(), seconds);
  if (after == times_.begin()) return 0;
  const auto frame = static_cast<std::size_t>(after - times_.begin()) - 1;
  const double next = frame + 1 < times_.size() ? times_[frame + 1] : length();
  return static_cast<double>(frame) + std::min(1.0, (seconds - times_[frame]) / (next - times_[frame]));
}

}  // namespace floatstage::apps
