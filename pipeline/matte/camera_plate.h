#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"
#include "matting/keyers/keyer.h"
#include "matting/keyers/plate.h"

namespace floatstage::pipeline {

struct CameraPlate {
  matting::Plate plate;
  std::unique_ptr<matting::Keyer> keyer;
  double unseen = 0;  ///< CameraKey::unseen()
};

/// The plate of one camera, from pictures of the empty stage (`shot`) or, where there are none, found behind
/// the performance: in 48 photographs spread over the take, then learnt again without what the last plate
/// keys. A place that fewer than three photographs show is unknown, and keys as subject.
/// Errors: Unsupported when the photographs agree nowhere, when they, or they and the shot plate, show that
/// the camera moved; InvalidArgument for `deviations` that cannot be.
Result<CameraPlate> plate_of(capture::TakeReader& take, int camera, const std::vector<Image>& shot,
                             std::optional<double> deviations);

}  // namespace floatstage::pipeline
