#pragma once

#include "capture/take.h"
#include "core/matte_edits.h"
#include "matting/video/video_matting.h"

namespace floatstage::pipeline {

/// A take's photographs of one camera as a clip: in a gap, the nearest photograph. `take` must outlive it.
matting::MattingClip clip_of(capture::TakeReader& take, int camera);

/// What a keyframe's strokes say, painted at a size in pixels of the photographs.
matting::MatteConstraint opinion_of(const MatteKeyframe& keyframe, int width, int height);

}  // namespace floatstage::pipeline
