#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "matting/keyers/cloth_measure.h"
#include "matting/keyers/row_measure.h"

// Private to the stage.
namespace floatstage::matting {

/// The chroma key of a row of RGB pixels, in vectors of whatever the processor has. The same bits on all.
struct ClothKernels {
  const char* name;  ///< of the instruction set
  /// Takes `count` pixels apart into r, g and b, which hold padded(count) bytes each.
  void (*split)(const std::uint8_t* rgb, std::size_t count, std::uint8_t* r, std::uint8_t* g,
                std::uint8_t* b);
  /// Of padded(count) pixels taken apart, where ClothMeasure::value() is at least 128 (subject), at least 24
  /// (faint) and above `doubtful`: bit x % 64 of word x / 64. What lies beyond the row says nothing.
  void (*classify)(const ClothMeasure& measure, const std::uint8_t* r, const std::uint8_t* g,
                   const std::uint8_t* b, std::size_t padded, std::uint64_t* subject, std::uint64_t* faint,
                   std::uint64_t* doubt);
  /// The value of padded(count) pixels as opacity, and 255 where it is above `doubtful`, else 0.
  void (*alphas)(const ClothMeasure& measure, const std::uint8_t* r, const std::uint8_t* g,
                 const std::uint8_t* b, std::size_t padded, std::uint8_t* alpha, std::uint8_t* doubt);
  /// `form` of `count` RGB pixels in steps of 1 / RowMeasure::kQuantum, rounded to the nearest.
  void (*quantize)(const ColorForm& form, const std::uint8_t* r, const std::uint8_t* g, const std::uint8_t* b,
                   std::size_t padded, std::int32_t* out);
};

const ClothKernels& cloth_kernels();            ///< the best that this processor has
std::vector<ClothKernels> all_cloth_kernels();  ///< all that it has, for tests

}  // namespace floatstage::matting
