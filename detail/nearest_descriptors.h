#pragma once

#include <vector>

#include "detail/features.h"

namespace floatstage::detail {

/// The descriptor most like another, and how far it and the next one are: squared distances, exact.
struct Nearest {
  int index = -1;        ///< -1: the other photograph has no features
  float first = kNone;   ///< squared distance
  float second = kNone;  ///< of the next nearest; kNone where there is only one
  static constexpr float kNone = 1e9F;
};

struct NearestBothWays {
  std::vector<Nearest> of_a;  ///< for every feature of a, the nearest of b
  std::vector<Nearest> of_b;
};

/// Compares all descriptors of two photographs, each pair once for both directions. Exact: whole numbers
/// below 2^24 in floats, so that every instruction set gives the same; of equals the first counts. Not
/// threaded.
NearestBothWays nearest_both_ways(const PhotoFeatures& a, const PhotoFeatures& b);

}  // namespace floatstage::detail
