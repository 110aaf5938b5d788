#pragma once

#include <cstdint>
#include <vector>

// Private to the stage.
namespace floatstage::recon {

/// Eight lines of one view in the plane of a face, in columns. Columns of lines that are not there hold
/// anything.
struct alignas(64) LineBlock {
  static constexpr int kLines = 8;
  double wa[kLines], wb[kLines];       ///< w where the line meets s = 0 and s = 1
  double left[kLines], right[kLines];  ///< its stretch of s
  double low[kLines], high[kLines];    ///< and of w
  /// Bit k is about line k, and 0 where it is not there: it is there; the inside of its view is below it;
  /// that end is a vertex above the window.
  std::uint8_t used, upper, left_above, right_above;
};

/// The line that is cut, from where it enters the window.
struct CutLine {
  double wa, wb, entry, right, low, high;
};

/// What a block of lines says about a line that is cut.
struct BlockRelation {
  std::int32_t change;       ///< of their view's state where the line is entered
  std::uint8_t crosses;      ///< bit k: line k crosses it
  std::uint8_t falls_below;  ///< where both end to the right, line k is above it
};

/// Finds that for a block, in vectors of whatever the processor has; the same bits on all.
using RelateBlock = BlockRelation (*)(const LineBlock& block, const CutLine& line);
struct RelateKernel {
  const char* name;  ///< of the instruction set
  RelateBlock relate;
};

const RelateKernel& relate_kernel();             ///< the best that this processor has
std::vector<RelateKernel> all_relate_kernels();  ///< all that it has, for tests

}  // namespace floatstage::recon
