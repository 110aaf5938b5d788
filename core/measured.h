#pragma once

#include <compare>
#include <iomanip>
#include <string>
#include <utility>

#include "core/check.h"
#include "core/text.h"

namespace floatstage {

/// A figure of a report: a number and how many observations it rests on, or that it was not measured and why
/// not. Never a 0 that stands for "nobody looked". (ADR 0223)
class Measured {
 public:
  Measured() = default;
  /// `count` >= 1: points, frames, pixels, whatever was counted. Not explicit: a bare number is one
  /// measurement.
  Measured(double value, long count = 1) : value_(value), count_(count) {
    FLOATSTAGE_CHECK(count > 0, "a figure that rests on nothing");
  }
  /// "no frame was held out": a clause that can stand behind "not measured, because ".
  static Measured not_measured(std::string because) {
    Measured m;
    m.because_ = std::move(because);
    return m;
  }
  /// The value where something was counted, else not measured.
  static Measured of(double value, long count, std::string because) {
    return count > 0 ? Measured(value, count) : not_measured(std::move(because));
  }

  explicit operator bool() const { return count_ > 0; }
  /// Only of what was measured.
  double operator*() const {
    FLOATSTAGE_CHECK(count_ > 0, "a figure that was not measured");
    return value_;
  }
  bool operator==(const Measured&) const = default;
  /// What was not measured is neither less nor more than anything.
  friend std::partial_ordering operator<=>(const Measured& a, const Measured& b) {
    return a && b ? a.value_ <=> b.value_ : std::partial_ordering::unordered;
  }
  long count() const { return count_; }  ///< 0: not measured
  const std::string& because() const { return because_; }

 private:
  double value_ = 0;
  long count_ = 0;
  std::string because_ = "nothing looked at it";
};

/// "0.213 px", or "not measured, because no frame was held out".
inline std::string to_words(const Measured& m, int digits, const char* unit = "") {
  if (!m) return "not measured, because " + m.because();
  return text(std::fixed, std::setprecision(digits), *m, unit);
}

/// The same where there is no room for the reason.
inline std::string short_words(const Measured& m, int digits, const char* unit = "") {
  return m ? to_words(m, digits, unit) : "not measured";
}

}  // namespace floatstage
