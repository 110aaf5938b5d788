#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/statistics.h"

namespace floatstage::capture {

/// How far apart the exposures of many sets lay, in bounded memory however many they are: a histogram whose
/// bins are a 128th of their value wide (HdrHistogram, Tene 2012). Of each bin the largest value is kept, so
/// percentiles are spreads that were seen: never below the true one, above it by less than a 128th, and
/// exact where a bin has one value; the largest is exact. Spreads of a second take 46 kB.
class Spreads {
 public:
  /// ns, >= 0.
  void add(std::int64_t spread) {
    const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(0, spread));
    const std::size_t bin = bin_of(value);
    if (bin >= bins_.size()) bins_.resize(bin + 1);
    ++bins_[bin].count;
    bins_[bin].largest = std::max(bins_[bin].largest, value);
    ++count_;
  }

  bool empty() const { return count_ == 0; }
  std::size_t bins() const { return bins_.size(); }
  void clear() { *this = {}; }

  /// percentile() of core/statistics.h, ns. There must be one spread at least.
  std::int64_t percentile(double share) const {
    const std::size_t rank = percentile_rank(count_, share);
    std::size_t seen = 0;
    for (const Bin& bin : bins_)
      if ((seen += bin.count) > rank) return static_cast<std::int64_t>(bin.largest);
    return 0;
  }

 private:
  static constexpr int kBits = 7;  // of a value that tell its bin, below the leading one

  struct Bin {
    std::size_t count = 0;
    std::uint64_t largest = 0;
  };

  // Below 2^(kBits + 1) every value has its own; from there each doubling has 2^kBits.
  static std::size_t bin_of(std::uint64_t value) {
    const int shift = std::max(0, static_cast<int>(std::bit_width(value)) - (kBits + 1));
    return (static_cast<std::size_t>(shift) << kBits) + static_cast<std::size_t>(value >> shift);
  }

  std::vector<Bin> bins_;
  std::size_t count_ = 0;
};

}  // namespace floatstage::capture
