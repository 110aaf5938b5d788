#pragma once

#include <string>
#include <vector>

#include "calib/rig_formats.h"
#include "core/measured.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::calib {

/// A rig whose lenses a format can hold.
struct FittedRig {
  Rig rig;
  /// One a camera: the furthest that a ray of the camera's picture lies from where the rig has it, in px. Not
  /// measured where the camera is held as it is.
  std::vector<Measured> residual_px;
};

/// Cameras that `holds` has room for stay bit by bit. The others get the nearest lens that it has room for:
/// focal lengths, principal point, the terms it holds and a turn of the camera are fitted to the rays of the
/// picture; a Brown-Conrady lens may become a fisheye where that is nearer. Unsupported names the camera
/// whose nearest lens is further off than `largest_px`, how far, and what else can be done. `format` is for
/// the sentence.
Result<FittedRig> fit_to_format(const Rig& rig, const LensLimits& holds, std::string_view format,
                                double largest_px);

}  // namespace floatstage::calib
