#include "studio/network/audience.h"

#include <algorithm>

namespace floatstage::studio::wire {

bool Audience::put(const std::string& peer, Watch watch, Clock::time_point now) {
  if (!seats_.contains(peer) && seats_.size() >= kMostPeers) forget_silent(now);
  if (!seats_.contains(peer) && seats_.size() >= kMostPeers) return false;
  seats_[peer] = {std::move(watch), now + kWatchHolds};
  return true;
}

void Audience::forget_silent(Clock::time_point now) {
  std::erase_if(seats_, [&](const auto& seat) { return seat.second.until <= now; });
}

bool Audience::wants(MessageKind kind, const std::string& serial) const {
  return std::any_of(seats_.begin(), seats_.end(),
                     [&](const auto& seat) { return seat.second.watch.covers(kind, serial); });
}

std::vector<std::string> Audience::who_wants(MessageKind kind, const std::string& serial) const {
  std::vector<std::string> who;
  for (const auto& [peer, seat] : seats_)
    if (seat.watch.covers(kind, serial)) who.push_back(peer);
  return who;
}

}  // namespace floatstage::studio::wire
