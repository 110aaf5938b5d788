#pragma once

#include <compare>
#include <cstdint>

namespace floatstage {

/// A span of time in nanoseconds.
struct Nanoseconds {
  std::int64_t count = 0;
  auto operator<=>(const Nanoseconds&) const = default;
};

/// An instant on the studio clock (PTP/TAI when locked, else the recorder's monotonic clock), in nanoseconds.
/// A frame's instant is the start of its exposure.
struct Timestamp {
  std::int64_t ns = 0;
  auto operator<=>(const Timestamp&) const = default;
};

constexpr Nanoseconds operator-(Timestamp a, Timestamp b) { return {a.ns - b.ns}; }
constexpr Timestamp operator+(Timestamp t, Nanoseconds d) { return {t.ns + d.count}; }
constexpr Timestamp operator-(Timestamp t, Nanoseconds d) { return {t.ns - d.count}; }
constexpr Nanoseconds operator+(Nanoseconds a, Nanoseconds b) { return {a.count + b.count}; }
constexpr Nanoseconds operator-(Nanoseconds a, Nanoseconds b) { return {a.count - b.count}; }
constexpr Nanoseconds operator*(Nanoseconds d, std::int64_t n) { return {d.count * n}; }

constexpr Nanoseconds milliseconds(std::int64_t n) { return {n * 1'000'000}; }
constexpr double seconds(Nanoseconds d) { return static_cast<double>(d.count) * 1e-9; }

}  // namespace floatstage
