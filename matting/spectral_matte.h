#pragma once

#include "core/image.h"
#include "core/result.h"
#include "matting/video/video_matting.h"

namespace floatstage::matting {

/// One picture's matte by spectral matting: its components at working size, chosen by what somebody says (or,
/// when nobody does, by the balanced split of least matting energy, guess_selection()), carried up to the
/// picture's size; what was said is then certain. A stroke or click marks its component; components nobody
/// marked count a little as background.
///
/// `picture`: 1 or 3 channels, at least 3x3. `said`: empty, or of the picture's size. Takes one to two
/// seconds and 0.4 GB whatever the size, one thread. Deterministic. Errors: what options.check() finds;
/// InvalidArgument for another size and for an opinion that marks background only; BadData for a picture of
/// one colour; Unsupported when memory does not suffice.
Result<Image> spectral_matte(const Image& picture, const MatteConstraint& said = {},
                             const VideoMattingOptions& options = {});

}  // namespace floatstage::matting
