#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/check.h"

namespace floatstage {

/// The percentile and the median that all of Floatstage means: the nearest rank (Hyndman & Fan 1996,
/// definition 1), the smallest of the values that at least `share` of them all are not above. It is one of
/// the values and never a mean of two, so an instant stays one that a camera took, a colour one that was
/// seen, and values may be infinite. `share` 0 is the smallest, 1 the largest; the median of an even number
/// is the lower of the middle two. Values are ordered by `<`; there must be one at least, and none may be
/// NaN. Linear in their number.

/// The index of the percentile among `count` sorted values.
inline std::size_t percentile_rank(std::size_t count, double share) {
  FLOATSTAGE_CHECK(count > 0, "a percentile of nothing");
  constexpr double kRounding = 1e-9;  // 0.07 × 100 is a little more than 7
  const double rank = std::ceil(share * static_cast<double>(count) - kRounding);
  return static_cast<std::size_t>(std::clamp(rank, 1.0, static_cast<double>(count))) - 1;
}

/// Brings the values into another order: for buffers that are used again.
template <class T>
T percentile_in_place(std::span<T> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(percentile_rank(values.size(), share));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

template <class T>
T percentile(std::vector<T> values, double share) {
  return percentile_in_place(std::span<T>(values), share);
}

template <class T>
T median(std::vector<T> values) {
  return percentile(std::move(values), 0.5);
}

}  // namespace floatstage
