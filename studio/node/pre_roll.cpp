#include "studio/node/pre_roll.h"

#include <algorithm>

#include "capture/recorder.h"

namespace floatstage::studio {

void PreRoll::push(Frame frame, std::uint64_t failed) {
  if (frame.empty()) return;
  kept_.push_back({capture::detached(frame), failed});
  const Timestamp newest = kept_.back().frame.info.exposure_start;
  while (kept_.size() > most_frames_ || newest - kept_.front().frame.info.exposure_start > longest_)
    kept_.pop_front();
}

std::deque<PreRoll::Kept> PreRoll::take() { return std::exchange(kept_, {}); }

std::vector<Timestamp> PreRoll::times() const {
  std::vector<Timestamp> times;
  for (const Kept& kept : kept_) times.push_back(kept.frame.info.exposure_start);
  return times;
}

std::optional<Timestamp> complete_instant(const std::vector<std::vector<Timestamp>>& times, Timestamp from,
                                          Nanoseconds period) {
  const auto first = std::find_if(times.begin(), times.end(), [](const auto& t) { return !t.empty(); });
  if (first == times.end()) return std::nullopt;
  const auto saw = [&](const std::vector<Timestamp>& camera, Timestamp instant) {
    const Nanoseconds half{period.count / 2};
    const auto near = std::lower_bound(camera.begin(), camera.end(), instant - half);
    return near != camera.end() && *near < instant + half;
  };
  std::optional<Timestamp> found;
  for (const Timestamp instant : *first) {
    const bool complete = std::all_of(times.begin(), times.end(), [&](const auto& camera) {
      return camera.empty() || saw(camera, instant);
    });
    if (!complete) continue;
    found = instant;
    if (instant >= from) break;
  }
  return found;
}

}  // namespace floatstage::studio
