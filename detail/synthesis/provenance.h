#pragma once

#include <cstdint>

namespace floatstage::detail {

/// Where a pixel comes from.
enum class Provenance : std::uint8_t {
  Upsampled = 0,    ///< the coarser pixels alone
  Synthesised = 1,  ///< with details from elsewhere
  Warped = 2,       ///< of a photograph of this place, bent to fit or mixed at its rim
  Real = 3          ///< of a photograph of this place
};

}  // namespace floatstage::detail
