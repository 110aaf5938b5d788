#pragma once

#include <filesystem>
#include <functional>

#include "apps/matte/camera_matter.h"

namespace floatstage {

/// One camera's mattes by spectral video matting: the key is the likelihood, strokes are keyframes, masks outrank both.
/// `cache` keeps the components, so that a second run only propagates. `done(frame, matte)` gets each matte in order, an
/// empty one for a gap, and stops the work by an error. With `threads` workers of about 0.4 GB each.
Result<void> spectral_mattes(TakeReader& take, const CameraMatter& matter, const std::filesystem::path& cache, int threads,
                             const std::function<Result<void>(int frame, Image matte)>& done);

}  // namespace floatstage
