#pragma once

#include <functional>
#include <map>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/video/video_matting.h"

namespace floatstage::matting {

struct SegmentClipOptions {
  int working_pixels = 130'000;  ///< photographs are scaled to about so many
  int rounds = 3;  ///< walks through the clip, each with what the one before has learnt; 1 … 10
  int training_frames =
      96;  ///< photographs, spread over the clip, that backdrop and colours are learnt from; 8 … 1000
  double smooth = 3;   ///< of a step of the outline, against log-likelihoods; 0 … 100
  double carried = 2;  ///< log-odds that the neighbours' mattes, carried by flow, are worth; 0 … 100

  Result<void> check() const;
};

/// One subject through a clip of a still camera before clutter, without a plate, from a click or two.
///
/// Round by round and frame by frame, forwards and backwards from the first keyframe, a minimum cut decides
/// between what is known of the subject (its colours, where the neighbours' mattes have moved to) and of each
/// place's backdrop (a plate that holds only what was seen while the place was background: behind somebody
/// who never left it, nothing is held, and the colours decide). Strokes are certain, and others who move are
/// left alone unless they touch the subject.
///
/// `clip`: its photographs are RGB; its likelihood is not used. `strokes`: by frame, of any size; at least
/// one marks subject. Returns a hard matte a frame, 0 or 255, of the working size: lay a band around it and
/// solve it (refine_matte). `done(round, frame)` may stop the work by returning false (Cancelled). Memory:
/// five bytes a working pixel and frame up to 400 MB, one beyond. Deterministic, one thread. Errors: those of
/// check() and of the photographs; InvalidArgument when no stroke marks subject or a frame is not in the
/// clip; BadData naming a photograph that has another size than the first.
Result<std::vector<Image>> segment_clip(const MattingClip& clip,
                                        const std::map<int, MatteConstraint>& strokes,
                                        const SegmentClipOptions& options = {},
                                        const std::function<bool(int round, int frame)>& done = nullptr);

}  // namespace floatstage::matting
