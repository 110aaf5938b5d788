#include "studio/node/camera_time.h"

#include <algorithm>

namespace floatstage::studio {
namespace {

constexpr Nanoseconds kHour = milliseconds(3'600'000);  // no picture is that old: another clock
constexpr Nanoseconds kFollow{1000};                    // a picture: 100 ppm at 100 pictures a second
constexpr std::int64_t kSecond = 1'000'000'000;

}  // namespace

Timestamp CameraTime::to_monotonic(Timestamp exposed, Timestamp produced) {
  const Nanoseconds apart = produced - exposed;
  const std::lock_guard lock(mutex_);
  if (apart < kHour && Nanoseconds{-apart.count} < kHour) {
    apart_.reset();
    return exposed;
  }
  const bool first = !apart_ || apart - *apart_ > kHour || *apart_ - apart > kHour;
  apart_ = first ? apart : std::min(apart, *apart_ + kFollow);
  return exposed + *apart_;
}

Timestamp CameraTime::produced(Timestamp exposed, Timestamp arrived) {
  return std::min(arrived, to_monotonic(exposed, arrived));
}

Nanoseconds CameraTime::to_system(Timestamp system, Timestamp monotonic) const {
  const std::lock_guard lock(mutex_);
  if (!apart_) return system - monotonic;
  const Nanoseconds between = system - (monotonic - *apart_);  // leap seconds, and what a picture takes
  const std::int64_t half = between.count < 0 ? -kSecond / 2 : kSecond / 2;
  return Nanoseconds{(between.count + half) / kSecond * kSecond} - *apart_;
}

}  // namespace floatstage::studio
