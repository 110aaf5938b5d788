#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Private to the stage.
namespace floatstage::matting {

/// The plate's key of a row of RGB pixels, in vectors of whatever the processor has. The same bits on all.
struct PlateKernels {
  const char* name;  ///< of the instruction set
  /// How far `count` pixels are from the plate's, in 8-bit steps: to the nearest colour that light alone
  /// makes of the plate, from `darkest` to `brightest` of it (Horprasert et al. 1999, eq. 5-6, as one
  /// distance).
  void (*lengths)(const std::uint8_t* rgb, const std::uint8_t* plate, std::size_t count, float darkest,
                  float brightest, float* out);
  /// The same as opacity: half at `thresholds`, none at half of them, 255 at one and a half, and where they
  /// are 0.
  void (*alphas)(const std::uint8_t* rgb, const std::uint8_t* plate, const float* thresholds,
                 std::size_t count, float darkest, float brightest, std::uint8_t* out);
};

const PlateKernels& plate_kernels();            ///< the best that this processor has
std::vector<PlateKernels> all_plate_kernels();  ///< all that it has, for tests

}  // namespace floatstage::matting
