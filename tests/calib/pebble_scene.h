#pragma once

#include <cstdint>
#include <vector>

#include "calib/markerless.h"
#include "core/rig.h"

namespace floatstage::calib {

/// A heap of pebbles with a fine solid pattern, and cameras around it that all have one lens: what markerless
/// calibration sees, with exact truth.
struct PebbleScene {
  Rig truth;                                ///< serials c00, c01, …; one model
  std::vector<MarkerlessPicture> pictures;  ///< grey; lens Unknown and shared by all; files are in the folder
};

enum class PebbleRig {
  Ring,  ///< 20 cameras on a circle, 15° above the middle
  Dome   ///< three rows of 10, 8 and 6 cameras over the front half, 5° to 45° above the middle
};

/// Every number that is left to chance follows from the seed: pebbles, pattern, how far cameras stand from
/// their places (2 % of the radius), focal length (1.2 to 2 widths), principal point, distortion, noise of
/// the pictures (2 grey levels). Pictures are saved as c00.png … into `folder`.
PebbleScene pebble_scene(PebbleRig shape, std::uint64_t seed, const std::filesystem::path& folder);

}  // namespace floatstage::calib
