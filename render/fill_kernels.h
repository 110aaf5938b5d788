#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Private to the stage.
namespace floatstage::render {

/// The rows of PictureFill, compiled for whatever instruction sets the processor may have; the same bits on
/// all.
struct FillKernels {
  const char* name;  ///< of the instruction set
  /// Of `count` pixels: one channel of `step` interleaved ones where known, else 0.
  void (*take)(const float* values, std::size_t step, const std::uint8_t* known, std::size_t count,
               float* value);
  /// A coarse pixel is the mean of the known ones among its four: two of row 0 and two of row 1.
  void (*pull)(const float* value0, const float* weight0, const float* value1, const float* weight1,
               std::size_t count, float* value);
  /// How far it is known.
  void (*pull_weights)(const float* weight0, const float* weight1, std::size_t count, float* weight);
  /// `count` coarse pixels at `width`, at most twice as many, linear between pixel centres.
  void (*expand)(const float* coarse, std::size_t count, std::size_t width, float* fine);
  /// Mixes a row with what two expanded rows say, by what it does not know.
  void (*push)(const float* top, float upper, const float* bottom, float lower, const float* weight,
               std::size_t count, float* value);
};

const FillKernels& fill_kernels();
std::vector<FillKernels> all_fill_kernels();  ///< all that this machine has, for tests

}  // namespace floatstage::render
