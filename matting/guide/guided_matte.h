#pragma once

#include <vector>

#include "core/image.h"
#include "core/matte_edits.h"
#include "core/result.h"

namespace floatstage::matting {

/// What became of one stroke.
enum class StrokeEffect {
  Acted,    ///< pixels of the matte are others because of it
  Already,  ///< everything that it marks was so
  Outside,  ///< it marks no pixel of the picture
};

struct GuidedMatte {
  Image matte;
  std::vector<StrokeEffect> effects;  ///< one a stroke
};

/// A matte that follows what a person says in its own frame, stroke after stroke, so that a stroke more never
/// takes back what the ones before have done.
///
/// What a stroke marks is as it says, exactly. If part of it was on the wrong side, what hangs together with
/// that by colour and contour turns over with it (stroke_region.h): missing parts come, and things that are
/// not the subject go. Nothing else changes. Where an outline is new, closed form solves its edge.
///
/// `picture`: RGB, at least 3x3. `matte`: one channel of its size. `fixed`: empty, or of its size: what is not
/// 128 there is certain and stays (garbage and hold-out masks). Deterministic, one thread; about 0.1 s a
/// stroke at 1280x720. Errors: those of closed_form_matte(); InvalidArgument for sizes that do not fit.
Result<GuidedMatte> guided_matte(const Image& picture, const Image& matte,
                                 const std::vector<MatteStroke>& strokes, const Image& fixed = {});

}  // namespace floatstage::matting
