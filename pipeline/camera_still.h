#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Whether all these pictures of one camera are from one place, "camera 'x' moved: …" with what to do as
/// Unsupported if not. `names`: of each, as "frame 12".
Result<void> check_still(const std::string& serial, const std::vector<Image>& pictures,
                         const std::vector<std::string>& names);

/// Likewise some photographs of a camera's take, from the first to the last. Errors: also those of reading.
Result<void> check_camera_still(capture::TakeReader& take, int camera);

}  // namespace floatstage::pipeline
