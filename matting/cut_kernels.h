#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Private to the stage.
namespace floatstage::matting {

/// How pixels differ from their neighbours, in vectors of whatever the processor has. The same on all.
struct CutKernels {
  using Planes = const std::uint8_t* const*;  ///< three of them
  struct Contrast {
    std::uint64_t sum = 0, pairs = 0;
    std::uint32_t most = 0;
  };
  const char* name;  ///< of the instruction set
  /// Squared differences of colours, at most `most`. Whole vectors of 16 are read and written.
  void (*differences)(Planes a, Planes b, std::size_t count, std::uint32_t most, std::uint32_t* out);
  /// Adds those of the pairs of which at least one is asked (1, else 0). Whole vectors of 16 are read.
  void (*add)(Planes a, Planes b, const std::uint8_t* asked_a, const std::uint8_t* asked_b, std::size_t count,
              Contrast& contrast);
};

const CutKernels& cut_kernels();            ///< the best that this processor has
std::vector<CutKernels> all_cut_kernels();  ///< all that it has, for tests

}  // namespace floatstage::matting
