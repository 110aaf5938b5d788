#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Private to the stage.
namespace floatstage::matting {

/// What is done to rows of bytes and numbers, in vectors of whatever the processor has.
/// The same on all.
struct RowKernels {
  const char* name;  ///< of the instruction set
  /// values[x] * steps, rounded to the nearest.
  void (*quantize)(const float* values, std::size_t padded, float steps, std::int32_t* out);
  /// out[x] becomes the larger, or the smaller, of both rows, which do not overlap.
  void (*raise)(const std::uint8_t* other, std::size_t count, std::uint8_t* out);
  void (*lower)(const std::uint8_t* other, std::size_t count, std::uint8_t* out);
};

const RowKernels& row_kernels();            ///< the best that this processor has
std::vector<RowKernels> all_row_kernels();  ///< all that it has, for tests

}  // namespace floatstage::matting
