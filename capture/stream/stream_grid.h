#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "core/time.h"

namespace floatstage::capture {

/// When pictures go out, and with which time: on a grid of constant rate, since mixers, recorders and
/// hardware decoders want one. A picture goes out at once as the instant it came in, unless that has its
/// picture: then at the beginning of the next. An instant that passed without one gets the last picture
/// again. Instants that passed while nobody could send (a slow receiver) are left out but for the last.
class StreamGrid {
 public:
  explicit StreamGrid(double rate) : period_(1e9 / rate) {}

  struct Due {
    std::int64_t instant = 0;  ///< place on the grid; grows from one to the next
    bool again = false;        ///< the last picture
    std::uint64_t missed = 0;  ///< instants between the one before and this that nothing was sent for
    bool operator==(const Due&) const = default;
  };

  /// What is to be sent now, if anything; it counts as sent. `fresh`: a picture waits that has not been.
  std::optional<Due> due(Timestamp now, bool fresh) {
    if (!origin_) {
      if (!fresh) return std::nullopt;
      origin_ = now;
    }
    const std::int64_t present = instant_at(now);
    if (any_ && present - 1 > last_) return send(present - 1, true);
    if (fresh && present > last_) return send(present, false);
    return std::nullopt;
  }
  /// When due() has an answer at the latest; absent before the first picture.
  std::optional<Timestamp> next(bool fresh) const {
    if (!origin_) return std::nullopt;
    return *origin_ + Nanoseconds{static_cast<std::int64_t>(
                          std::ceil(period_ * static_cast<double>(last_ + (fresh ? 1 : 2))))};
  }
  /// Somebody watches from now on: what went by before is not missed.
  void resume(Timestamp now) {
    if (origin_) last_ = std::max(last_, instant_at(now) - 1);
  }

 private:
  std::int64_t instant_at(Timestamp now) const {
    return static_cast<std::int64_t>(std::floor(static_cast<double>((now - *origin_).count) / period_));
  }
  Due send(std::int64_t instant, bool again) {
    const Due due{instant, again, static_cast<std::uint64_t>(instant - last_ - 1)};
    last_ = instant;
    any_ = any_ || !again;
    return due;
  }

  const double period_;  // ns
  std::optional<Timestamp> origin_;
  std::int64_t last_ = -1;
  bool any_ = false;
};

}  // namespace floatstage::capture
