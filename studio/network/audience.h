#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "studio/messages/watch_message.h"

namespace floatstage::studio::wire {

/// The peers of a publisher and what each of them watches. A watch holds for kWatchHolds after it was said,
/// so that who fell silent is forgotten; nobody's watch is at another's cost, and all of them together take
/// less than 10 MB: at most kMostPeers of kMostWatched serials each. Not for several threads at once.
class Audience {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMostPeers = 64;
  static constexpr std::chrono::milliseconds kWatchHolds{5000};

  /// False for a new peer where there are kMostPeers already.
  bool put(const std::string& peer, Watch watch, Clock::time_point now);
  void forget(const std::string& peer) { seats_.erase(peer); }
  void forget_silent(Clock::time_point now);

  bool wants(MessageKind kind, const std::string& serial) const;
  std::vector<std::string> who_wants(MessageKind kind, const std::string& serial) const;
  std::size_t size() const { return seats_.size(); }

 private:
  struct Seat {
    Watch watch;
    Clock::time_point until;
  };
  std::map<std::string, Seat> seats_;
};

}  // namespace floatstage::studio::wire
