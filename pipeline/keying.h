#pragma once

#include <memory>
#include <string>

#include "capture/take.h"
#include "core/result.h"
#include "matting/keyers/keyer.h"

namespace floatstage::pipeline {

/// The keyer of one camera: `spec` completed from its clean plate, or else from a few of its photographs.
Result<std::unique_ptr<matting::Keyer>> keyer_for(capture::TakeReader& take, int camera,
                                                  const std::string& spec);

}  // namespace floatstage::pipeline
